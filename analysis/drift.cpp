// SPDX-License-Identifier: Apache-2.0
#include "analysis/drift.hpp"

#include <algorithm>
#include <limits>

#include "analysis/line_fit.hpp"

namespace lcrig {

namespace {

// Rests without any scatter all get the same weight.
double weight_of(const RestNode& n) {
  return n.se_fF > 0 ? 1 / (n.se_fF * n.se_fF) : 1e12;
}

}  // namespace

Drift::Drift(std::vector<RestNode> nodes) : nodes_(std::move(nodes)) {
  if (nodes_.size() < 2) return;
  std::vector<LinePoint> points;
  points.reserve(nodes_.size());
  for (const RestNode& n : nodes_) points.push_back({n.t_s, n.fF, weight_of(n)});
  const auto line = fit_line(points);
  if (!line) {
    nodes_.resize(1);
    return;
  }
  t_mean_ = line->x_mean;
  rate_ = line->slope;
  weights_ = line->sum_weights;
  stt_ = line->sxx;
  for (const RestNode& n : nodes_) deviations_.push_back(n.fF - line->at(n.t_s));
  const double freedom = line->points - 2;
  // The weights are 1/variance, so noise alone makes the mean square 1.
  const double excess = freedom > 0 ? line->residual_ss / freedom : 0;
  follow_ = excess > 1 ? 1 - 1 / excess : 0;
  freedom_ = excess > 1 ? freedom : std::numeric_limits<double>::infinity();
  const bool exact = std::ranges::none_of(nodes_, [](const RestNode& n) { return n.se_fF > 0; });
  rate_se_ = line->slope_se(exact ? excess : std::max(1.0, excess));
  rate_white_ = exact ? 0 : line->slope_se(1);
  follow(follow_);
}

std::vector<double> Drift::rate_influence() const {
  std::vector<double> out;
  out.reserve(nodes_.size());
  for (const RestNode& n : nodes_) out.push_back(weight_of(n) * (n.t_s - t_mean_) / stt_);
  return out;
}

void Drift::follow(double part) {
  follow_ = part;
  if (known()) zero_ = raw(nodes_.front().t_s);
}

double Drift::raw(double t_s) const {
  const double line = rate_ * (std::max(t_s, nodes_.front().t_s) - t_mean_);
  if (follow_ <= 0) return line;
  if (t_s <= nodes_.front().t_s) return line + follow_ * deviations_.front();
  if (t_s >= nodes_.back().t_s) return line + follow_ * deviations_.back();
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), t_s,
                                      [](double t, const RestNode& n) { return t < n.t_s; });
  const auto k = static_cast<std::size_t>(after - nodes_.begin());
  const double part = (t_s - nodes_[k - 1].t_s) / (nodes_[k].t_s - nodes_[k - 1].t_s);
  return line + follow_ * (deviations_[k - 1] + part * (deviations_[k] - deviations_[k - 1]));
}

double Drift::at(double t_s) const {
  return known() ? raw(t_s) - zero_ : 0;
}

std::vector<double> Drift::influence(double t_s) const {
  std::vector<double> out(nodes_.size(), 0.0);
  if (!known()) return out;
  // Moves each node by 1 fF in turn. For a given `follow_` the deviations are linear in the nodes.
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Drift moved = *this;
    const double w = weight_of(nodes_[i]);
    const double mean = w / weights_, rate = w * (nodes_[i].t_s - t_mean_) / stt_;
    moved.rate_ = rate;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      moved.deviations_[k] = (k == i ? 1.0 : 0.0) - mean - rate * (nodes_[k].t_s - t_mean_);
    }
    moved.follow(follow_);
    out[i] = moved.at(t_s);
  }
  return out;
}

}  // namespace lcrig
