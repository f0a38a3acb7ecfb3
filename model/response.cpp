// SPDX-License-Identifier: Apache-2.0
#include "model/response.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcrig {
namespace {

constexpr std::size_t kFirstCells = 8;
constexpr std::size_t kMostCells = 1U << 15U;

// Derivative of equally spaced values, fourth order: central from five values, one-sided at the
// ends.
double slope_at(const std::vector<double>& y, std::size_t i, double h) {
  const std::size_t last = y.size() - 1;
  if (i >= 2 && i + 2 <= last) {
    return (y[i - 2] - 8 * y[i - 1] + 8 * y[i + 1] - y[i + 2]) / (12 * h);
  }
  if (i == 1) return (-3 * y[0] - 10 * y[1] + 18 * y[2] - 6 * y[3] + y[4]) / (12 * h);
  if (i + 1 == last) {
    return (3 * y[last] + 10 * y[i] - 18 * y[i - 1] + 6 * y[i - 2] - y[i - 3]) / (12 * h);
  }
  return (25 * y[last] - 48 * y[last - 1] + 36 * y[last - 2] - 16 * y[last - 3] + 3 * y[last - 4]) /
         (12 * h);
}

// Fritsch and Carlson's condition: a cubic stays monotone if each slope is at most three times both
// neighbouring secants.
double limited(double slope, double left, double right) {
  return std::clamp(slope, 0.0, 3 * std::min(left, right));
}

struct Sample {
  double shortening_m, delta_F;
};

// Samples on a uniform grid, which is halved until the previous table meets the tolerance at all
// new points.
class TableBuilder {
 public:
  TableBuilder(LevelModel& model, double area_m2, double tolerance)
      : model_(model), area_m2_(area_m2), tolerance_(tolerance) {}

  // Takes the first samples over as much of the range as the level can solve.
  Result<> reach(double max_force_N) {
    const double tiny = 1e-7 * max_force_N;
    auto first = sample(tiny);
    auto second = sample(2 * tiny);
    if (!first || !second) return fail(first ? second.error() : first.error());
    const auto at_zero = [&](double f1, double f2) { return (2 * f1 - f2 / 2) / tiny; };
    initial_slope_ = {at_zero(first->shortening_m, second->shortening_m),
                      at_zero(first->delta_F, second->delta_F)};
    Error why;
    for (double top = max_force_N; top > 1e-3 * max_force_N; top *= 0.9) {
      auto last = sample(top);
      if (last) {
        max_force_N_ = top;
        samples_ = {Sample{0, 0}, *last};
        return {};
      }
      why = last.error();
      if (const auto reached = model_.last_converged()) {
        top = std::min(top, reached->si() * area_m2_ / 0.9);  // the next try is at this load
      }
    }
    return fail(std::move(why));
  }

  Result<> refine() {
    while (samples_.size() <= kFirstCells || error_ > tolerance_) {
      if (samples_.size() > kMostCells) {
        return fail(Errc::invalid_request,
                    "a table of {} cells still errs by {:.2g}, more than {:.2g}: ask for a smaller "
                    "largest force or a larger tolerance",
                    samples_.size() - 1, error_, tolerance_);
      }
      if (auto ok = halve(); !ok) return ok;
    }
    return {};
  }

  double max_force_N() const { return max_force_N_; }
  double error() const { return error_; }
  MonotoneTable shortening() const { return table(&Sample::shortening_m); }
  MonotoneTable delta() const { return table(&Sample::delta_F); }

 private:
  Result<Sample> sample(double force_N) {
    auto state = model_.at_pressure(Pressure::from_si(force_N / area_m2_));
    if (!state) return fail(state.error());
    return Sample{state->shortening_m, state->delta_capacitance_F};
  }

  Result<> halve() {
    std::vector<Sample> finer;
    const double half = step() / 2;
    for (std::size_t i = 0; i + 1 < samples_.size(); ++i) {
      auto middle = sample(static_cast<double>(2 * i + 1) * half);
      if (!middle) return fail(middle.error());
      finer.push_back(samples_[i]);
      finer.push_back(*middle);
    }
    finer.push_back(samples_.back());
    error_ = samples_.size() > kFirstCells / 2 + 1 ? worst_error(finer) : 1;
    samples_ = std::move(finer);
    return {};
  }

  double step() const { return max_force_N_ / static_cast<double>(samples_.size() - 1); }

  MonotoneTable table(double Sample::* member) const {
    std::vector<double> values;
    values.reserve(samples_.size());
    for (const auto& s : samples_) values.push_back(s.*member);
    return MonotoneTable(step(), values, initial_slope_.*member);
  }

  double worst_error(const std::vector<Sample>& exact) const {
    const MonotoneTable shortening_table = shortening();
    const MonotoneTable delta_table = delta();
    double worst = 0;
    for (std::size_t i = 1; i < exact.size(); i += 2) {
      const double force = step() / 2 * static_cast<double>(i);
      worst = std::max({worst, std::abs(shortening_table(force) / exact[i].shortening_m - 1),
                        std::abs(delta_table(force) / exact[i].delta_F - 1)});
    }
    return worst;
  }

  LevelModel& model_;
  double area_m2_, tolerance_;
  double max_force_N_ = 0;
  double error_ = 0;
  Sample initial_slope_{};  // per N
  std::vector<Sample> samples_;
};

}  // namespace

MonotoneTable::MonotoneTable(double step, const std::vector<double>& values, double initial_slope)
    : step_(step) {
  const std::size_t last = values.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const double left = i > 0 ? (values[i] - values[i - 1]) / step : 0;
    const double right = i < last ? (values[i + 1] - values[i]) / step : left;
    const double slope = i > 0 ? slope_at(values, i, step) : initial_slope;
    nodes_.push_back({values[i], limited(slope, i > 0 ? left : right, right) * step});
  }
}

double MonotoneTable::operator()(double x) const {
  const double u = x / step_;
  if (!(u > 0)) return 0;
  const auto last = static_cast<double>(nodes_.size() - 1);
  if (u >= last) return nodes_.back().value + nodes_.back().slope * (u - last);
  const auto i = static_cast<std::size_t>(u);
  const double s = u - static_cast<double>(i);
  const Node& a = nodes_[i];
  const Node& b = nodes_[i + 1];
  const double rise = b.value - a.value;
  const double c2 = 3 * rise - 2 * a.slope - b.slope;
  const double c3 = a.slope + b.slope - 2 * rise;
  return a.value + s * (a.slope + s * (c2 + s * c3));
}

Result<std::unique_ptr<TabulatedResponse>> make_response(const Specimen& specimen,
                                                         const LevelSettings& settings,
                                                         Force max_force, double tolerance) {
  if (!(tolerance >= 1e-6 && tolerance <= 1) || !(max_force.si() > 0) ||
      !std::isfinite(max_force.si())) {
    return fail(Errc::invalid_request,
                "model table: tolerance {} must be 1e-6 to 1, largest force {} N positive",
                tolerance, max_force.si());
  }
  auto model = make_level_model(specimen, settings);
  if (!model) return fail(model.error());
  TableBuilder builder(**model, specimen.area_m2(), tolerance / 10);
  if (auto ok = builder.reach(max_force.si()); !ok) return fail(ok.error());
  if (auto ok = builder.refine(); !ok) return fail(ok.error());
  return std::make_unique<TabulatedResponse>((*model)->c0_F(), builder.shortening(),
                                             builder.delta(), builder.max_force_N(),
                                             builder.error());
}

}  // namespace lcrig
