// SPDX-License-Identifier: Apache-2.0
#include "analysis/export_context.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/decimal.hpp"
#include "events/payloads.hpp"
#include "storage/frame_capabilities.hpp"

namespace lcrig {

namespace {

struct ValueColumn {
  std::string_view sql;
  Column column;
  int power;
  std::string_view functions;  // functions of the meter that fill the column, each between spaces
};
constexpr std::array<ValueColumn, 7> kValues{{
    {"capacitance_F",
     {"capacitance_pF", "number", "pF", "capacitance"},
     12,
     " Cs-Rs Cs-D Cp-Rp Cp-D "},
    {"dissipation", {"dissipation", "number", "1", "dissipation factor D"}, 0, " Cs-D Cp-D "},
    {"resistance_ohm", {"resistance_ohm", "number", "ohm", "resistance"}, 0, " Cs-Rs Cp-Rp R-X "},
    {"reactance_ohm", {"reactance_ohm", "number", "ohm", "reactance"}, 0, " R-X "},
    {"impedance_ohm",
     {"impedance_ohm", "number", "ohm", "modulus of the impedance"},
     0,
     " Z-thr Z-thd "},
    {"phase_rad", {"phase_rad", "number", "rad", "phase of the impedance"}, 0, " Z-thr "},
    {"phase_deg", {"phase_deg", "number", "deg", "phase of the impedance"}, 0, " Z-thd "},
}};

// The capacitance always has a column. Another value has one if a function of the run measures it.
Result<> load_value_columns(const Database& db, ExportContext& c) {
  std::array<bool, kValues.size()> used{true};
  const auto take = [&used](const Statement& row) {
    const std::string function = fmt::format(" {} ", row.text(0));
    for (std::size_t i = 0; i < kValues.size(); ++i) {
      if (kValues[i].functions.find(function) != std::string_view::npos) used[i] = true;
    }
  };
  auto all = db.each("SELECT DISTINCT function FROM lcr_reading WHERE run_id = ?", take, c.id);
  if (!all) return all;
  for (std::size_t i = 0; i < kValues.size(); ++i) {
    if (!used[i]) continue;
    c.value_columns.push_back(kValues[i].column);
    c.value_powers.push_back(kValues[i].power);
    c.value_sql += fmt::format(", {}", kValues[i].sql);
  }
  return {};
}

void add_settings(ExportContext& c, std::int64_t at, std::string_view stored) {
  c.before.add(at, stored);
  const auto settings = from_json<SettingsEvent>(stored);
  if (settings && settings->frequency_Hz) c.frequencies.push_back({at, *settings->frequency_Hz});
}

// Runs of old versions may hold a text for people where newer ones hold a payload.
Result<> load_events(const Database& db, ExportContext& c) {
  constexpr const char* kEvents =
      "SELECT at_mono_ns, detail FROM event WHERE run_id = ? AND kind = ? ORDER BY seq";
  const auto take_contact = [&c](const Statement& row) {
    const auto contact = from_json<ContactEvent>(row.text(1));
    if (contact) c.contacts.push_back({row.integer(0), contact->travel_m});
  };
  auto contacts = db.each(kEvents, take_contact, c.id, EventKind::contact);
  if (!contacts) return contacts;
  return db.each(
      kEvents, [&c](const Statement& row) { add_settings(c, row.integer(0), row.text(1)); }, c.id,
      EventKind::settings);
}

// Finds the last digit of the samples. A simulated sample or a dead weight has as many digits as a
// double, so at most nine digits of the largest value count.
class DigitEnd {
 public:
  void add(const std::optional<double>& value) {
    const auto places = value ? decimal_places(*value) : std::nullopt;
    if (!places) return;
    first_ = std::max(first_.value_or(places->first), places->first);
    last_ = std::min(last_.value_or(places->last), places->last);
  }
  int or_else(int unknown) const { return last_ ? std::max(*last_ - 1, *first_ - 8) : unknown; }

 private:
  std::optional<int> first_, last_;
};

Result<> load_digit_ends(const Database& db, ExportContext& c) {
  DigitEnd force, travel;
  const auto take = [&](const Statement& row) {
    force.add(row.optional_real(0));
    travel.add(row.optional_real(1));
  };
  auto all = db.each("SELECT force_N, travel_m FROM frame_sample WHERE run_id = ?", take, c.id);
  if (!all) return all;
  c.ends.force_N = force.or_else(c.ends.force_N);
  c.ends.travel_m = travel.or_else(c.ends.travel_m);
  if (!c.area_m2) return {};
  const double step_Pa = std::pow(10.0, c.ends.force_N) / *c.area_m2;
  c.ends.pressure_Pa = static_cast<int>(std::floor(std::log10(step_Pa)));
  return {};
}

}  // namespace

Result<ExportContext> load_context(const Database& db, std::int64_t run) {
  auto row = get_run(db, run);
  if (!row) return fail(row.error());
  ExportContext c;
  c.id = run;
  c.run = std::move(*row);
  c.start_ns = c.run.started.time_since_epoch().count();
  c.area_m2 = c.run.probe_area_m2();
  c.hold_force = parse_capabilities(c.run.frame_capabilities_json).weights;
  add_settings(c, INT64_MIN, c.run.lcr_settings_json);
  if (auto r = keep(DeviceClock::fit(db, run), c.clock); !r) return fail(r.error());
  if (auto r = keep(Proof::load(db, run), c.proof); !r) return fail(r.error());
  if (auto r = load_value_columns(db, c); !r) return fail(r.error());
  if (auto r = load_events(db, c); !r) return fail(r.error());
  if (auto r = load_digit_ends(db, c); !r) return fail(r.error());
  return c;
}

}  // namespace lcrig
