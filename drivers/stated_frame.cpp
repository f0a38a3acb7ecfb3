// SPDX-License-Identifier: Apache-2.0
#include "drivers/stated_frame.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/decimal.hpp"

namespace lcrig {

namespace {

double si_of(Duration time) {
  return to_seconds(time);
}
double si_of(ForceClass cell) {
  return cell.percent();
}
template <class Quantity>
double si_of(Quantity q) {
  return q.si();
}

enum class Worse { larger, smaller };

class Counting {
 public:
  explicit Counting(std::vector<std::string>& differences) : differences_(differences) {}

  // `key`: of the config file; `digits` shifts SI to its unit.
  template <class T>
  T worse(const char* key, int digits, T by_gateway, T by_person, Worse rule = Worse::larger) {
    const double gateway = si_of(by_gateway), person = si_of(by_person);
    if (gateway == person) return by_gateway;
    const bool of_person = rule == Worse::larger ? person > gateway : person < gateway;
    differences_.push_back(fmt::format(
        "the frame states {:.6g} for {}, the config {:.6g}: {} counts, because it is worse",
        shift_decimal(gateway, digits), key, shift_decimal(person, digits),
        of_person ? "that of the config" : "that of the frame"));
    return of_person ? by_person : by_gateway;
  }
  template <class T>
  void take(const char* key, int digits, std::optional<T>& by_gateway,
            const std::optional<T>& by_person) {
    if (by_gateway && by_person) {
      by_gateway = worse(key, digits, *by_gateway, *by_person);
    } else if (by_person) {
      by_gateway = by_person;
    }
  }
  ForceLoop loop(const ForceLoop& a, const ForceLoop& b);

 private:
  std::vector<std::string>& differences_;
};

ForceLoop Counting::loop(const ForceLoop& a, const ForceLoop& b) {
  ForceLoop out;
  out.approach = worse("frame.force_loop.approach_mm_s", 3, a.approach, b.approach);
  out.contact = worse("frame.force_loop.contact_N", 0, a.contact, b.contact);
  out.rate_max = worse("frame.force_loop.rate_max_N_s", 0, a.rate_max, b.rate_max, Worse::smaller);
  out.lag = worse("frame.force_loop.lag_s", 0, a.lag, b.lag);
  out.ripple = worse("frame.force_loop.ripple_N", 0, a.ripple, b.ripple);
  out.stiffness_max = worse("frame.force_loop.stiffness_max_N_mm", -3, a.stiffness_max,
                            b.stiffness_max, Worse::smaller);
  // HOLD goes to its force at rate_max, and then overshoots by that rate times the lag. The smaller
  // rate must not make this smaller than either side states.
  if (out.rate_max.si() > 0) {
    for (const ForceLoop& one : {a, b}) {
      const double over_N = one.rate_max.si() * to_seconds(one.lag);
      out.lag = std::max(out.lag, from_seconds(over_N / out.rate_max.si()));
    }
  }
  return out;
}

}  // namespace

CountedCapabilities count_the_worse(FrameCapabilities by_gateway, const StatedFrame& by_person) {
  CountedCapabilities out;
  FrameCapabilities& c = out.capabilities = std::move(by_gateway);
  Counting counting(out.differences);
  counting.take("frame.force_class", 0, c.force_class, by_person.force_class);
  counting.take("frame.travel_step_um", 6, c.travel_step, by_person.travel_step);
  counting.take("frame.force_step_mN", 3, c.force_step, by_person.force_step);
  counting.take("frame.filter_s", 0, c.filter, by_person.filter);
  counting.take("frame.play_um", 6, c.play, by_person.play);
  if (c.force_loop && by_person.force_loop) {
    c.force_loop = counting.loop(*c.force_loop, *by_person.force_loop);
  } else if (by_person.force_loop) {
    c.force_loop = by_person.force_loop;
  }
  return out;
}

std::vector<std::string> missing_statements(const FrameCapabilities& c) {
  std::vector<std::string> out;
  if (c.travel_channel && c.motion && !c.travel_step) out.emplace_back("frame.travel_step_um");
  if (c.force_hold && !c.force_loop) out.emplace_back("frame.force_loop");
  return out;
}

}  // namespace lcrig
