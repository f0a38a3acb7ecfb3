// SPDX-License-Identifier: Apache-2.0
#include "analysis/conditions.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/metrics.hpp"
#include "storage/frame_capabilities.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

std::optional<std::string> unless_empty(std::string words) {
  return words.empty() ? std::nullopt : std::optional(std::move(words));
}

// A simulated bench that draws its errors is another rig for each seed of the draw. nullopt: the
// run does not say which rig it was. Empty: nothing was drawn.
std::optional<std::string> drawn_rig(const RunRow& row) {
  if (!row.model_error_json) return "";
  const json model = json::parse(*row.model_error_json, nullptr, false);
  if (!model.is_object() || !model.contains("drawn")) return "";
  const auto seed = model.find("rig_seed");
  if (seed == model.end() || !seed->is_number_integer()) return std::nullopt;
  return fmt::format(", rig {}", seed->get<std::int64_t>());
}

// A meter without a serial number is known by its whole reply, which others of its kind give, too.
std::string meter_of(const RunConditions& c, const RunRow& row) {
  const bool has_serial = c.corrections && c.corrections->meter != row.lcr_identity;
  return has_serial ? c.corrections->meter : "";
}

std::string probe_of(const StoredCapabilities& stored) {
  if (stored.probe_serial.empty() || stored.probe_name.empty()) {
    return stored.probe_serial.empty() ? stored.probe_name : stored.probe_serial;
  }
  return stored.probe_name + " " + stored.probe_serial;
}

void read_identities(const RunData& data, RunConditions& c) {
  if (data.replayed) return;  // they are those of the playback
  const auto rig = drawn_rig(data.row);
  if (!rig) return;
  const auto named = [&rig](std::optional<std::string> words) {
    if (words) *words += *rig;
    return words;
  };
  const StoredCapabilities stored = parse_capabilities(data.row.frame_capabilities_json);
  c.meter = named(unless_empty(meter_of(c, data.row)));
  c.cell = named(unless_empty(stored.cell_serial));
  c.probe = named(unless_empty(probe_of(stored)));
}

}  // namespace

RunConditions conditions_of(const RunView& view, std::optional<double> c0_pF) {
  const RunData& data = view.data;
  RunConditions c;
  c.corrections = data.corrections;
  read_identities(data, c);
  c.measured = data.function.substr(0, data.function.find('-'));
  if (view.setting_known) c.setting = view.setting;
  if (c.setting && c0_pF && *c0_pF > 0) {
    c.impedance_ohm = 1 / (2 * std::numbers::pi * c.setting->frequency_Hz * *c0_pF * 1e-12);
  }
  c.dead_weights = data.dead_weights;
  c.force_class_percent =
      force_limit_percent(view.options.rig, data.force_class_percent, data.dead_weights);
  c.probe_diameter_m = data.probe_diameter_m;
  c.specimen_text = data.row.specimen_text;
  c.disc_diameter_m = data.pressure.disc_diameter_m;
  c.simulated = data.row.simulated;
  c.replayed = data.replayed;
  return c;
}

json identities_json(const RunConditions& c) {
  const auto or_null = [](const std::optional<std::string>& words) {
    return words ? json(*words) : json(nullptr);
  };
  return {{"meter", or_null(c.meter)}, {"load_cell", or_null(c.cell)}, {"probe", or_null(c.probe)}};
}

}  // namespace lcrig
