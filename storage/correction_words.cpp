// SPDX-License-Identifier: Apache-2.0
// The functions of corrections.hpp that need no database: JSON for a run's row, and words for
// people.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/iso_time.hpp"
#include "base/json_or_null.hpp"
#include "base/time.hpp"
#include "storage/corrections.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

constexpr const char* kStrayLimit = "stray_limit_F";

json state_json(const CorrectionState& state) {
  return {{"on", json_or_null(state.on)},
          {"made_unix_ns", json_or_null(state.made_unix_ns)},
          {"made_by", state.made_unix_ns ? json(state.made_by) : json()}};
}

CorrectionState read_state(const json& all, CorrectionKind kind) {
  CorrectionState out;
  const auto found = all.find(to_string(kind));
  if (found == all.end() || !found->is_object()) return out;
  const auto member = [&found](const char* name) {
    const auto it = found->find(name);
    return it == found->end() ? json() : *it;
  };
  if (const json on = member("on"); on.is_boolean()) out.on = on.get<bool>();
  if (const json made = member("made_unix_ns"); made.is_number_integer()) {
    out.made_unix_ns = made.get<std::int64_t>();
  }
  if (const json by = member("made_by"); by.is_string()) out.made_by = by.get<std::string>();
  return out;
}

}  // namespace

json to_json(const MeterCorrections& meter) {
  json out{{"meter", meter.meter},
           {"simulated", meter.simulated},
           {"open", state_json(meter.open)},
           {"short", state_json(meter.short_circuit)}};
  if (meter.stray_limit_F) out[kStrayLimit] = *meter.stray_limit_F;
  return out;
}

std::optional<MeterCorrections> parse_corrections(std::string_view text) {
  return read_corrections(json::parse(text, nullptr, false));
}

std::optional<MeterCorrections> read_corrections(const json& all) {
  if (!all.is_object()) return std::nullopt;
  const auto name = all.find("meter");
  if (name == all.end() || !name->is_string()) return std::nullopt;
  MeterCorrections out;
  out.meter = name->get<std::string>();
  const auto simulated = all.find("simulated");
  out.simulated = simulated != all.end() && *simulated == true;
  for (const CorrectionKind kind : kCorrectionKinds) out.of(kind) = read_state(all, kind);
  const auto limit = all.find(kStrayLimit);
  if (limit != all.end() && limit->is_number()) out.stray_limit_F = limit->get<double>();
  return out;
}

std::int64_t days_between(std::int64_t made_unix_ns, std::int64_t at_unix_ns) {
  return std::max<std::int64_t>(0, at_unix_ns / kDay_ns - made_unix_ns / kDay_ns);
}

bool is_in_future(const CorrectionState& state, std::int64_t at_unix_ns) {
  return state.made_unix_ns.value_or(at_unix_ns) > at_unix_ns;
}

std::string correction_words(const CorrectionState& state, std::int64_t at_unix_ns,
                             std::string_view before) {
  const char* const on = !state.on ? "not known whether on" : *state.on ? "on" : "off";
  if (!state.on && !state.made_unix_ns) return "never made through lcrig";
  if (!state.made_unix_ns) return fmt::format("{}, not made through lcrig", on);
  const auto days = days_between(*state.made_unix_ns, at_unix_ns);
  const auto age = is_in_future(state, at_unix_ns) ? std::string("the date is in the future")
                   : days == 0                     ? std::string("the same day")
                   : days == 1                     ? fmt::format("a day {}", before)
                                                   : fmt::format("{} days {}", days, before);
  return fmt::format("{}, made {} UTC by {} ({})", on,
                     iso_time(*state.made_unix_ns).replace(10, 1, " ").substr(0, 16), state.made_by,
                     age);
}

}  // namespace lcrig
