// SPDX-License-Identifier: Apache-2.0
// The set-up of the meter as a table: commands, wanted values, read-backs.
#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/lcr6100/codec.hpp"
#include "drivers/lcr6100/words.hpp"

namespace lcrig::lcr6100 {

namespace {

constexpr std::array<std::string_view, 3> kRates{"FAST", "MED", "SLOW"};

// Field 0 or 1 of a reply such as `FAST,1` (APER?).
std::string_view field(std::string_view reply, int index) {
  const auto comma = reply.find(',');
  if (index == 0) return trimmed(reply.substr(0, comma));
  return comma == reply.npos ? std::string_view() : trimmed(reply.substr(comma + 1));
}

// The read-back's resolution: half a step of the level's three decimals and of the bias's two, five
// steps of the frequency's six, because the generator has steps of its own.
double tolerance(SettingId id, double wanted) {
  switch (id) {
    case SettingId::level: return 0.6e-3 * std::abs(wanted);
    case SettingId::bias: return 0.006;
    case SettingId::frequency: return 5e-6 * std::abs(wanted);
    default: return 0;
  }
}

bool is_number(SettingId id) {
  return id == SettingId::level || id == SettingId::bias || id == SettingId::frequency ||
         id == SettingId::source_resistance;
}

}  // namespace

std::vector<Setting> settings_for(const MeterState& wanted) {
  using Id = SettingId;
  const LcrSettings& s = wanted.settings;
  const CorrectionsOn& on = wanted.corrections;
  std::vector<Setting> out;
  out.reserve(17);
  const auto add = [&out](Id id, std::string_view name, const char* header, std::string value) {
    out.emplace_back(id, name, header, std::move(value));
  };
  add(Id::page, "display page", "DISP:PAGE", "MEAS");
  add(Id::function, "function", "FUNC", std::string(to_string(s.function)));
  add(Id::auto_function, "automatic function", "FUNC:IMP:AUTO", "OFF");
  add(Id::auto_range, "range", "FUNC:RANG:AUTO", "AUTO");
  add(Id::source_resistance, "source resistance", "LEV:SRES", "100");
  add(Id::level, "level", "LEV:VOLT", format_parameter(s.level.si()));
  add(Id::alc, "level control", "LEV:ALC", "OFF");
  add(Id::bias, "bias", "BIAS", s.bias ? format_parameter(s.bias->si()) : "OFF");
  add(Id::frequency, "frequency", "FREQ", format_parameter(s.frequency.si()));
  add(Id::aperture, "aperture", "APER", std::string(kRates[static_cast<std::size_t>(s.aperture)]));
  add(Id::average, "average", "APER", std::to_string(s.average));
  const auto add_switch = [&](Id id, std::string_view name, const char* header, bool state) {
    add(id, name, header, state ? "ON" : "OFF");
  };
  if (on.open) add_switch(Id::open_correction, "open correction", "CORR:OPEN:STAT", *on.open);
  if (on.short_circuit) {
    add_switch(Id::short_correction, "short correction", "CORR:SHOR:STAT", *on.short_circuit);
  }
  // While those above settle. No value depends on these.
  add(Id::monitor1, "monitor 1", "FUNC:MON1", "OFF");
  add(Id::monitor2, "monitor 2", "FUNC:MON2", "OFF");
  add(Id::comparator, "comparator", "COMP:STAT", "OFF");
  add(Id::trigger, "trigger", "TRIG:SOUR", s.trigger == LcrTrigger::bus ? "BUS" : "INT");
  return out;
}

std::vector<Setting> read_backs_for(const MeterState& wanted) {
  using Id = SettingId;
  static constexpr std::array kOrder{Id::function,
                                     Id::auto_function,
                                     Id::level,
                                     Id::alc,
                                     Id::frequency,
                                     Id::bias,
                                     Id::aperture,
                                     Id::average,
                                     Id::open_correction,
                                     Id::trigger,
                                     Id::short_correction,
                                     Id::auto_range,
                                     Id::source_resistance};
  const std::vector<Setting> all = settings_for(wanted);
  std::vector<Setting> out;
  out.reserve(kOrder.size());
  for (const Id id : kOrder) {
    const auto it = std::ranges::find(all, id, &Setting::id);
    if (it != all.end()) out.push_back(*it);
  }
  return out;
}

bool must_settle(SettingId id) {
  return id != SettingId::page && id != SettingId::monitor1 && id != SettingId::monitor2 &&
         id != SettingId::comparator && id != SettingId::trigger;
}

std::string_view key_of(SettingId id) {
  switch (id) {
    case SettingId::page: return "page";
    case SettingId::function: return "function";
    case SettingId::auto_function: return "automatic_function";
    case SettingId::auto_range: return "range";
    case SettingId::monitor1: return "monitor1";
    case SettingId::monitor2: return "monitor2";
    case SettingId::source_resistance: return "source_resistance_ohm";
    case SettingId::level: return "level_V";
    case SettingId::alc: return "level_control";
    case SettingId::bias: return "bias_V";
    case SettingId::comparator: return "comparator";
    case SettingId::frequency: return "frequency_Hz";
    case SettingId::aperture: return "aperture";
    case SettingId::average: return "average";
    case SettingId::trigger: return "trigger";
    case SettingId::open_correction: return "open_correction";
    case SettingId::short_correction: return "short_correction";
  }
  return "";
}

std::optional<bool> parse_switch(std::string_view reply) {
  reply = trimmed(reply);
  if (same_word(reply, "ON") || reply == "1") return true;
  if (same_word(reply, "OFF") || reply == "0") return false;
  return std::nullopt;
}

bool matches(const Setting& setting, std::string_view reply) {
  reply = trimmed(reply);
  const auto wanted = parse_with_unit(setting.wanted);
  if (is_number(setting.id) && wanted) {
    const auto got = parse_with_unit(reply);
    return got && std::abs(*got - *wanted) <= tolerance(setting.id, *wanted);
  }
  if (setting.id == SettingId::aperture) return same_word(field(reply, 0), setting.wanted);
  if (setting.id == SettingId::average) return field(reply, 1) == setting.wanted;
  if (setting.id == SettingId::open_correction || setting.id == SettingId::short_correction) {
    return parse_switch(reply) == parse_switch(setting.wanted);
  }
  if (setting.id == SettingId::page) return same_word(reply.substr(0, 4), setting.wanted);
  return same_word(reply, setting.wanted);
}

void apply(const Setting& setting, std::string_view reply, LcrSettings& s) {
  const auto value = parse_with_unit(reply);
  if (!value) return;  // words need no reading: they matched exactly
  if (setting.id == SettingId::level) s.level = Voltage::from_si(*value);
  if (setting.id == SettingId::frequency) s.frequency = Frequency::from_si(*value);
  if (setting.id == SettingId::bias) s.bias = Voltage::from_si(*value);
}

}  // namespace lcrig::lcr6100
