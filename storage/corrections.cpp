// SPDX-License-Identifier: Apache-2.0
#include "storage/corrections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/iso_time.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

constexpr CorrectionKind kKinds[] = {CorrectionKind::open, CorrectionKind::short_circuit};

// False: its schema is older.
Result<bool> stores_corrections(const Database& db) {
  auto tables = db.integer("SELECT count(*) FROM sqlite_schema WHERE name = 'lcr_correction'");
  if (!tables) return fail(tables.error());
  return *tables > 0;
}

json state_json(const CorrectionState& state) {
  return {{"on", state.on ? json(*state.on) : json()},
          {"made_unix_ns", state.made_unix_ns ? json(*state.made_unix_ns) : json()},
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

Result<> add_correction(const Database& db, const StoredCorrection& made) {
  return db.change(
      "INSERT INTO lcr_correction (kind, meter, lcr_identity, simulated, operator, operator_uid,"
      " made_unix_ns) VALUES (?,?,?,?,?,?,?)",
      to_string(made.kind), std::string_view(made.meter), std::string_view(made.lcr_identity),
      std::int64_t{made.simulated ? 1 : 0}, std::string_view(made.operator_name), made.operator_uid,
      made.made_unix_ns);
}

Result<> look_up_corrections(const Database& db, MeterCorrections& meter) {
  auto known = stores_corrections(db);
  if (!known) return fail(known.error());
  if (!*known) return {};
  for (const CorrectionKind kind : kKinds) {
    CorrectionState& state = meter.of(kind);
    auto found = db.each(
        "SELECT made_unix_ns, operator FROM lcr_correction WHERE meter = ? AND kind = ?"
        " ORDER BY id DESC LIMIT 1",
        [&state](const Statement& s) {
          state.made_unix_ns = s.integer(0);
          state.made_by = s.text(1);
        },
        std::string_view(meter.meter), to_string(kind));
    if (!found) return found;
  }
  return {};
}

Result<std::vector<MeterCorrections>> list_corrections(const Database& db) {
  auto known = stores_corrections(db);
  if (!known) return fail(known.error());
  if (!*known) return std::vector<MeterCorrections>();
  auto meters = db.rows(
      "SELECT meter, max(simulated) FROM lcr_correction GROUP BY meter ORDER BY max(id) DESC",
      [](const Statement& s) {
        MeterCorrections out;
        out.meter = s.text(0);
        out.simulated = s.integer(1) != 0;
        return out;
      });
  if (!meters) return meters;
  for (MeterCorrections& meter : *meters) {
    if (auto found = look_up_corrections(db, meter); !found) return fail(found.error());
  }
  return meters;
}

std::string to_json(const MeterCorrections& meter) {
  const json out{{"meter", meter.meter},
                 {"simulated", meter.simulated},
                 {"open", state_json(meter.open)},
                 {"short", state_json(meter.short_circuit)}};
  return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::optional<MeterCorrections> parse_corrections(std::string_view text) {
  const json all = json::parse(text, nullptr, false);
  if (!all.is_object()) return std::nullopt;
  const auto name = all.find("meter");
  if (name == all.end() || !name->is_string()) return std::nullopt;
  MeterCorrections out;
  out.meter = name->get<std::string>();
  const auto simulated = all.find("simulated");
  out.simulated = simulated != all.end() && *simulated == true;
  for (const CorrectionKind kind : kKinds) out.of(kind) = read_state(all, kind);
  return out;
}

std::int64_t days_between(std::int64_t made_unix_ns, std::int64_t at_unix_ns) {
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
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
