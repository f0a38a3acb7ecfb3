// SPDX-License-Identifier: Apache-2.0
#include "protocols/contact/contact_slope.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lcrig {

namespace {

// The fall of the force from one look to a later one.
struct Drop {
  double force_N = 0, error_N = 0, way_m = 0, resolution_m = 0;
  double relaxed_N = 0;  // of the force, at most

  // The stiffness that it proves, whatever relaxed.
  double proves_N_m() const {
    if (!(way_m + resolution_m > 0)) return 0;
    return std::max(0.0, force_N - error_N - relaxed_N) / (way_m + resolution_m);
  }

  bool is_clear() const { return force_N >= kBoundSigmas * error_N && is_sure_way(); }
  bool is_sure_way() const { return way_m > kBeyondStep * resolution_m; }
  ContactSlope slope() const {
    ContactSlope s;
    if (way_m > 0) s.about = force_N / way_m;
    if (way_m + resolution_m > 0) {
      s.at_least = std::max(0.0, (force_N - error_N) / (way_m + resolution_m));
    }
    s.at_most = is_sure_way() ? (std::max(0.0, force_N) + error_N) / (way_m - resolution_m)
                              : std::numeric_limits<double>::infinity();
    return s;
  }
};

class WayBack {
 public:
  WayBack(std::span<const RestMeasurement> looks, const RetreatFacts& facts)
      : looks_(looks), facts_(facts), relaxes_N_s_(1, facts.relaxes_N_s) {
    find_fallen();
  }
  std::size_t size() const { return looks_.size(); }
  Drop drop(std::size_t from, std::size_t to) const {
    const RestMeasurement& a = looks_[from];
    const RestMeasurement& b = looks_[to];
    Drop d;
    d.force_N = a.force_N() - b.force_N();
    d.error_N = kBoundSigmas * std::hypot(a.error_N(), b.error_N()) +
                facts_.drift_N_s * seconds_between(a, b);
    d.way_m = a.travel_m().value_or(0) - b.travel_m().value_or(0);
    d.resolution_m = facts_.resolution_m;
    if (const double s = seconds_between(a, b); s > 0) d.relaxed_N = relaxes_N_s_[from] * s;
    return d;
  }
  // Whether motion had let the force fall at this look. Then the lost motion of the drive was over.
  bool has_fallen(std::size_t look) const { return look >= fallen_; }

 private:
  void find_fallen() {
    for (std::size_t to = 1; to < looks_.size(); ++to) {
      relaxes_N_s_.push_back(relaxes_N_s_.back());
      for (std::size_t from = 0; from < to; ++from) {
        const Drop d = drop(from, to);
        const bool falls = d.force_N > std::max(d.error_N + d.relaxed_N, kGone * facts_.felt_N);
        if (falls) fallen_ = std::min(fallen_, to);
        double& relaxes = relaxes_N_s_.back();
        relaxes = std::min(relaxes, fastest_fall_N_s(looks_[from], looks_[to]));
      }
    }
  }

  std::span<const RestMeasurement> looks_;
  const RetreatFacts facts_;
  std::vector<double> relaxes_N_s_;  // after each look, at most
  std::size_t fallen_ = std::numeric_limits<std::size_t>::max();  // the first look with a fall
                                                                  // that no relaxation explains
};

// The slope from the first look, if the force fell from there on. Takes the one known best: the
// lowest of several bounds would be one that noise made too low.
std::optional<ContactSlope> slope_from_contact(const WayBack& way, std::size_t touching) {
  std::optional<ContactSlope> best;
  bool falls = way.has_fallen(1);  // before `to`, or on the first step
  for (std::size_t to = 1; to < touching; ++to) {
    const Drop drop = way.drop(0, to);
    const ContactSlope slope = drop.slope();
    if (falls && drop.is_clear() && (!best || slope.doubt() < best->doubt())) best = slope;
    falls = way.has_fallen(to);
    for (std::size_t later = to + 1; later < way.size(); ++later) {
      if (slope.at_most < way.drop(to, later).proves_N_m()) return std::nullopt;
    }
  }
  return best;
}

// The steepest slope that begins after the force had fallen.
std::optional<ContactSlope> slope_from_later(const WayBack& way, std::size_t touching) {
  std::optional<ContactSlope> steepest;
  for (std::size_t from = 1; from < touching; ++from) {
    if (!way.has_fallen(from)) continue;
    for (std::size_t to = from + 1; to < touching; ++to) {
      const Drop drop = way.drop(from, to);
      const ContactSlope slope = drop.slope();
      if (!drop.is_clear()) continue;
      if (!steepest || slope.at_least > steepest->at_least) steepest = slope;
    }
  }
  return steepest;
}

// The stiffness that the ways to these looks prove at least.
double least_N_m(const WayBack& way, std::size_t to, std::size_t end) {
  double least = 0;
  for (; to < end; ++to) {
    for (std::size_t from = 0; from < to; ++from) {
      least = std::max(least, way.drop(from, to).proves_N_m());
    }
  }
  return least;
}

bool have_travel(std::span<const RestMeasurement> looks) {
  return std::ranges::all_of(
      looks, [](const RestMeasurement& look) { return look.travel_m().has_value(); });
}

}  // namespace

double seconds_between(const RestMeasurement& a, const RestMeasurement& b) {
  return a.begin() && b.begin() ? std::abs(to_seconds(*b.begin() - *a.begin())) : 0;
}

double fastest_fall_N_s(const RestMeasurement& from, const RestMeasurement& to) {
  const double s = seconds_between(from, to);
  if (!(s > 0)) return std::numeric_limits<double>::infinity();
  const double error_N = kBoundSigmas * std::hypot(from.error_N(), to.error_N());
  return std::max(0.0, from.force_N() - to.force_N() + error_N) / s;
}

double proven_stiffness_N_m(std::span<const RestMeasurement> looks, const RetreatFacts& facts) {
  if (!have_travel(looks)) return 0;
  return least_N_m(WayBack(looks, facts), 1, looks.size());
}

std::optional<ContactSlope> contact_slope(std::span<const RestMeasurement> looks,
                                          std::size_t touching, const RetreatFacts& facts) {
  looks = looks.first(std::min(looks.size(), touching + 1));
  touching = std::min(touching, looks.size());
  if (!have_travel(looks)) return std::nullopt;
  const WayBack way(looks, facts);
  auto whole = slope_from_contact(way, touching);
  const auto later = slope_from_later(way, touching);
  if (whole && later) whole->at_most = std::max(whole->at_most, later->about);
  // On the way to a look without contact the probe pressed for a part only, so the contact is even
  // stiffer than the slope.
  const double pressed_N_m = least_N_m(way, 1, touching);
  const double lost_N_m = least_N_m(way, touching, way.size());
  if (whole && whole->at_most >= lost_N_m) {
    whole->at_most = std::max(whole->at_most, pressed_N_m);
    return whole;
  }
  if (later && later->at_most >= std::max(pressed_N_m, lost_N_m)) return later;
  return std::nullopt;
}

}  // namespace lcrig
