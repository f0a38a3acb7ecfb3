// SPDX-License-Identifier: Apache-2.0
#include "analysis/pressure_of_run.hpp"

#include "base/strict_json.hpp"
#include "model/specimen_file.hpp"

namespace lcrig {

PressureArea pressure_of_run(const RunRow& row) {
  PressureArea out;
  out.probe_diameter_m = row.probe_diameter_m;
  if (const auto specimen = parse_specimen(row.specimen_text, row.specimen_name)) {
    put_disc(*specimen, out);
  }
  const auto protocol = JsonDocument::parse(row.protocol_text, row.protocol_name);
  if (!protocol) return out;
  const JsonReader top(*protocol);
  if (!top.is_object()) return out;
  const auto on = parse_word<PressureOn>(top.optional_string("pressure_on").value_or(""));
  if (on && top.result()) out.on = *on;
  return out;
}

}  // namespace lcrig
