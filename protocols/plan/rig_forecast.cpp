// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/rig_forecast.hpp"

#include <fmt/format.h>

#include <limits>

namespace lcrig {

Forecast make_forecast(const Rig& rig) {
  constexpr double kRigid = std::numeric_limits<double>::infinity();
  ForceBound bound(rig.specimen_least_m, rig.frame_stiffness_N_m.value_or(kRigid));
  std::optional<ForceBound> expected;
  if (rig.compression_m) {
    expected.emplace(rig.compression_m);
    bound.at_least(*expected);
  }
  std::optional<ForceBound> if_free;
  if (rig.specimen_free_m) {
    if_free.emplace(rig.specimen_free_m, rig.frame_stiffness_N_m.value_or(kRigid));
  }
  return Forecast(rig.frame, std::move(bound), std::move(expected), std::move(if_free));
}

namespace {

// What the samples show, as the gateway or a person states it, and what nobody states.
void add_statements(const FrameCapabilities& c, std::vector<std::string>& out) {
  std::string stated, missing;
  const auto add = [](std::string& list, const std::string& words) {
    list += (list.empty() ? "" : ", ") + words;
  };
  const auto item = [&](const char* what, std::optional<double> value, const char* unit) {
    if (value) {
      add(stated, fmt::format("{} {:.4g} {}", what, *value, unit));
    } else {
      add(missing, what);
    }
  };
  const auto si = [](const auto& quantity, double to_unit) {
    return quantity ? std::optional(quantity->si() * to_unit) : std::nullopt;
  };
  item("step of the travel", si(c.travel_step, 1e6), "um");
  item("step of the force", si(c.force_step, 1e3), "mN");
  item("filter of the cell", c.filter ? std::optional(to_seconds(*c.filter) * 1e3) : std::nullopt,
       "ms");
  item("play of the drive", si(c.play, 1e6), "um");
  if (!stated.empty()) out.push_back("as stated: " + stated);
  if (!missing.empty()) out.push_back("nobody states, so bounded or measured: " + missing);
}

}  // namespace

std::vector<std::string> forecast_assumptions(const Rig& rig, const Forecast& forecast) {
  std::vector<std::string> out;
  out.push_back(rig.frame_stiffness_N_m
                    ? fmt::format("frame and cell are at most {:.4g} N/mm stiff, as stated",
                                  *rig.frame_stiffness_N_m * 1e-3)
                    : "frame and cell are taken for rigid: no stiffness_N_mm is stated for them");
  out.push_back(
      rig.specimen_least_m
          ? "the specimen is at most as stiff as with layers that cannot move sideways, or that "
            "nothing holds, whichever is stiffer at that force"
          : "the specimen is taken for rigid: its stiffness is not known");
  if (forecast.bound().is_bounded()) {
    out.push_back(fmt::format(
        "so the contact is at most {:.4g} N/mm stiff at 0 N, {:.4g} N/mm at 1 N",
        forecast.bound().stiffness_N_m(0) * 1e-3, forecast.bound().stiffness_N_m(1) * 1e-3));
  }
  out.push_back(
      fmt::format("a stop begins within {:.4g} ms and decelerates with {:.4g} mm/s2, as the "
                  "frame says",
                  to_seconds(rig.frame.reaction) * 1e3, rig.frame.deceleration.si() * 1e3));
  add_statements(rig.frame, out);
  return out;
}

}  // namespace lcrig
