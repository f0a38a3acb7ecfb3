// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sample_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace lcrig {

namespace {

// Arrivals of this time are compared, the quickest one of each part of it.
constexpr double kWindow_s = 10, kPart_s = 0.25;
constexpr double kFrozen_s = 0.5;
constexpr double kReportedError = 0.01;  // worse than any crystal
// A clock is as fast as it was in the first ten seconds, but for their jitter and its warming.
constexpr double kChanges = 0.003;
constexpr double kShortest_s = 2;  // from which its rate is measured
constexpr double kStraight_s = 0.03;  // about what is left of the jitter of the quickest arrivals
// docs/frame-link.md: two samples of a batch are at most 0.1 s apart.
constexpr double kStep_s = 0.1;

}  // namespace

SampleClock::Finding SampleClock::add(std::span<const FrameSample> batch) {
  Finding out;
  const FrameSample& first = batch.front();
  const FrameSample& last = batch.back();
  if (!first.device_time_s || !last.device_time_s) return out;
  const double host_s = to_seconds(last.received.time_since_epoch());
  const bool moves = last_device_s_ != last.device_time_s;
  const bool steps = steps_within(batch);
  out.news = follow(host_s, *last.device_time_s, moves);
  if (stands_since_s_ || is_useless_) return out;  // such a clock gives no ages
  remember({host_s, *last.device_time_s});
  if (auto told = judge_rate()) out.news = std::move(told);
  if (!steps && !is_useless_) out.age_s = age_s(host_s, *first.device_time_s);
  return out;
}

// Whether the clock itself was set between two samples that follow each other. The link reports it.
bool SampleClock::steps_within(std::span<const FrameSample> batch) {
  bool within = false;
  for (const FrameSample& s : batch) {
    if (!s.device_time_s) continue;
    const std::int64_t samples = s.device_seq - last_seq_;
    if (last_device_s_ && samples > 0 && *s.device_time_s != *last_device_s_) {
      const double passed_s = *s.device_time_s - *last_device_s_;
      const double usual_s = period_s_ * static_cast<double>(samples);
      const double each_s = passed_s / static_cast<double>(samples);
      // Twice the same is another rate.
      const bool again = std::abs(each_s - last_each_s_) < 0.1 * std::abs(last_each_s_);
      const bool steps = period_s_ > 0 ? std::abs(passed_s - usual_s) > kStep_s : passed_s < 0;
      const bool stepped = steps && !(again && each_s > 0);
      if (stepped) quickest_.clear();
      within = within || (stepped && &s != &batch.front());
      if (!stepped && (period_s_ == 0 || each_s < period_s_ || steps)) period_s_ = each_s;
      last_each_s_ = each_s;
    }
    last_seq_ = s.device_seq;
    last_device_s_ = s.device_time_s;
  }
  return within;
}

std::optional<SampleClock::News> SampleClock::follow(double host_s, double device_s, bool moves) {
  if (moves) {
    if (stands_since_s_) quickest_.clear();
    stands_since_s_.reset();
    return std::nullopt;
  }
  if (!stands_since_s_) stands_since_s_ = host_s;
  if (host_s - *stands_since_s_ < kFrozen_s || std::exchange(frozen_reported_, true)) return {};
  return News(
      EventKind::device_clock_frozen,
      fmt::format("the device's clock stands at {:.3f} s: nobody knows how old its samples are",
                  device_s));
}

void SampleClock::remember(Arrival now) {
  while (!quickest_.empty() && now.host_s - quickest_.front().host_s > 2 * kWindow_s) {
    quickest_.pop_front();
  }
  const auto part = [](const Arrival& a) { return std::floor(a.host_s / kPart_s); };
  const auto delay = [](const Arrival& a) { return a.host_s - a.device_s; };
  if (quickest_.empty() || part(quickest_.back()) != part(now)) {
    quickest_.push_back(now);
  } else if (delay(now) <= delay(quickest_.back())) {
    quickest_.back() = now;
  }
}

// From the quickest arrivals of four parts of the time so far, which lie on a straight line if it
// is the clock that is slow: a gateway that falls behind begins to at some time. After ten seconds
// the clock keeps the rate that it had.
std::optional<SampleClock::News> SampleClock::judge_rate() {
  const Arrival from = quickest_.front();
  const double span_s = quickest_.back().host_s - from.host_s;
  if (span_s < kShortest_s) return std::nullopt;
  std::array<Arrival, 4> best;
  std::array<double, 4> least{};
  least.fill(HUGE_VAL);
  for (const Arrival& a : quickest_) {
    const auto part = std::min<std::size_t>(
        best.size() - 1, static_cast<std::size_t>(4 * (a.host_s - from.host_s) / span_s));
    if (a.host_s - a.device_s >= least.at(part)) continue;
    best.at(part) = a;
    least.at(part) = a.host_s - a.device_s;
  }
  const double host = best.back().host_s - best.front().host_s;
  const double device = best.back().device_s - best.front().device_s;
  if (!(host > 0)) return std::nullopt;
  const double rate = device / host;
  for (const Arrival& a : best) {
    const double off_s =
        a.host_s - best.front().host_s - (a.device_s - best.front().device_s) / rate;
    if (!(std::abs(off_s) < kStraight_s)) return std::nullopt;
  }
  const double error = kChanges + kStraight_s / span_s;
  if (!is_measured_) {
    slowest_ = std::max(rate - error, 1 - kMostError);
    fastest_ = std::min(rate + error, 1 + kMostError);
  }
  if (span_s < kWindow_s) return std::nullopt;
  is_measured_ = true;
  is_useless_ = std::abs(rate - 1) > kMostError;
  const bool is_right = std::abs(rate - 1) < kReportedError + kStraight_s / span_s;
  if (is_right || std::exchange(rate_reported_, true)) return std::nullopt;
  return News(
      EventKind::device_clock_rate,
      fmt::format("the device's clock went {:.3f} s in {:.3f} s: its rate is wrong", device, host));
}

// The least age that any rate explains: no earlier sample can have arrived before it was taken. As
// a function of the rate that is the largest of straight lines, so it has one minimum.
double SampleClock::age_s(double host_s, double device_s) const {
  const auto at = [&](double host_of_device) {
    double age = 0;
    for (const Arrival& a : quickest_) {
      age = std::max(age, host_s - a.host_s - host_of_device * (device_s - a.device_s));
    }
    return age;
  };
  double low = 1 / std::max(slowest_, fastest_), high = 1 / slowest_;
  for (int i = 0; i < 30; ++i) {
    const double third = (high - low) / 3;
    if (at(low + third) < at(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  return at((low + high) / 2);
}

}  // namespace lcrig
