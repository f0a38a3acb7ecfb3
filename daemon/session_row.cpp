// SPDX-License-Identifier: Apache-2.0
// Makes the row of a session's run: everything known before its first reading.
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/decimal.hpp"
#include "base/units.hpp"
#include "daemon/record/stored_frame.hpp"
#include "daemon/rig/corrector.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/session.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

StoredCapabilities capabilities_of(const FrameCapabilities& c, const InstrumentsInfo& info) {
  StoredCapabilities out = stored_capabilities(c);
  if (!c.weights) out.cell_serial = info.frame.cell_serial;
  out.probe_serial = info.fixture.probe_serial;
  out.probe_name = info.fixture.probe_name;
  return out;
}

std::string limits_json(const BoundLimits& l) {
  json out{{"force_min_N", l.force_min_N}, {"force_max_N", l.force_max_N}};
  if (l.travel_min_m) out["travel_min_m"] = *l.travel_min_m;
  if (l.travel_max_m) out["travel_max_m"] = *l.travel_max_m;
  if (l.speed_max_m_s) out["speed_max_m_s"] = *l.speed_max_m_s;
  if (l.gap_min_m) out["gap_min_m"] = *l.gap_min_m;
  if (l.gap_max_m) out["gap_max_m"] = *l.gap_max_m;
  return out.dump();
}

// Parameters as bound, in the unit of the name's suffix.
std::string parameters_json(const Environment& environment) {
  json out = json::object();
  for (const auto& [name, value] : environment.values()) {
    const double to_si = split_key(name).to_si();
    const double power = std::log10(to_si);
    const bool decimal = power == std::round(power);
    out[name] = decimal ? shift_decimal(value, -static_cast<int>(power)) : value / to_si;
  }
  return out.dump();
}

}  // namespace

RunRow Session::make_row() const {
  const RunRequest& request = prepared_.request;
  const InstrumentsInfo& info = instruments_->info();
  const Duration conversion = instruments_->meter().capabilities().conversion_time(settings_);
  RunRow row;
  row.protocol_name = prepared_.protocol.name;
  row.protocol_text = request.protocol_text;
  row.parameters_json = parameters_json(prepared_.environment);
  row.specimen_name = request.specimen_name;
  row.specimen_text = request.specimen_text;
  row.probe_diameter_m = info.fixture.probe_diameter_m;
  row.lcr_identity = meter_identity_.text;
  row.frame_identity = frame_identity_.text;
  row.lcr_settings_json = to_json(settings_event(settings_, conversion));
  row.frame_capabilities_json = to_json(capabilities_of(rig_.frame, info));
  row.frame_limits_json = limits_json(plan_.limits);
  row.corrections =
      corrections_of(meter_identity_, info.simulated || meter_identity_.simulated, corrections_);
  row.corrections->stray_limit_F = info.fixture.stray_limit_F;
  row.bench_name = info.bench_name;
  row.bench_text = info.bench_text;
  row.simulated = simulated();
  row.seed = info.seed;
  row.model_level = info.model_level;
  row.model_error_json = info.model_json;
  row.operator_name = request.operator_name;
  row.note = request.note;
  row.started_unix_ns = clock_.unix_ns();
  row.started = clock_.now();
  row.boot_id = read_boot_id();
  row.queue_entry = prepared_.queue_entry;
  return row;
}

}  // namespace lcrig
