// SPDX-License-Identifier: Apache-2.0
// The LCR-6000 dialect: pure functions from bytes to values and back. Used by driver and settings.
// Sources: manual of the series, PDF p.98 ff. (commands, line ends, numbers), and real meters.
//
// Reading line: `<primary>,<secondary>[,<mon1>,<mon2>],<bin>,<aux>,<total>` CR LF, for example
// `+4.64627e-10,+3.88413e-03,OUT ,AUX-NG,NG`; DCR has one number and no <aux>. Numbers are C
// "%+.5e" in SI units; 1e20 is an overload. The words are the comparator's verdict and say nothing
// about validity.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/lcr_meter.hpp"

namespace lcrig::lcr6100 {

struct ReadingLine {
  std::optional<double> primary, secondary;  // SI
  std::uint32_t flags = 0;  // lcr_flag
  int numbers = 0;  // numbers on the line, overloads included: 1 to 4
  std::string_view values;  // the numbers as sent
  std::string_view status;  // the words as sent
};
// The views point into `line`. Errors: garbled.
Result<ReadingLine> parse_reading(std::string_view line);

// `LCR-6100,REV E8.13,GEZ883880,Good Will Instrument Co., Ltd.` Errors: garbled.
Result<Identity> parse_identity(std::string_view line);
bool is_supported_model(std::string_view model);

// A number in the meter's output format, "%+.5e".
std::string format_number(double value);
// A number as a parameter: the shortest form that reads back the same.
std::string format_parameter(double value);
// The SI value of `1.000000e+03`, `1.000e-01V`, `+2.50V`, `12ms` or `100`. nullopt: not a number
// with a known unit.
std::optional<double> parse_with_unit(std::string_view text);

// `on`, `off`, `1` or `0`, in any case. nullopt: something else.
std::optional<bool> parse_switch(std::string_view reply);

enum class SettingId {
  page,
  function,
  auto_function,
  auto_range,
  monitor1,
  monitor2,
  source_resistance,
  level,
  alc,
  bias,
  comparator,
  frequency,
  aperture,
  average,
  trigger,
  open_correction,
  short_correction
};

// One line of the set-up: the command, the query that reads it back, and the expected answer.
struct Setting {
  Setting(SettingId i, std::string_view n, std::string h, std::string v)
      : id(i), name(n), set(h + " " + v), query(std::move(h) + "?"), wanted(std::move(v)) {}
  SettingId id;
  std::string_view name;  // for messages
  std::string set, query;  // command lines
  std::string wanted;
};
// All settings in the order in which to send them; the trigger comes last.
std::vector<Setting> settings_for(const MeterState& wanted);
// Those that a value depends on, in the order in which to read them back: one query for aperture
// and average, and no two neighbours with the same answer, so that a line too old by one is
// noticed.
std::vector<Setting> read_backs_for(const MeterState& wanted);
// Whether values depend on it, which takes time.
bool must_settle(SettingId id);
// The key of a setting in the event `read_back`.
std::string_view key_of(SettingId id);
// True when the read-back equals the wanted value. The case of words is ignored; numbers may differ
// by the meter's resolution. A reply that does not parse does not match.
bool matches(const Setting& setting, std::string_view reply);
// Stores a matching read-back in `s`, with the meter's own digits.
void apply(const Setting& setting, std::string_view reply, LcrSettings& s);

// Whether the meter cannot have measured this value: a capacitance of exactly 0, or one that is
// negative beyond the meter's error; an impedance that is not positive; a resistance beyond its
// display.
bool is_out_of_range(const LcrSettings& s, double primary);

// Ranges and conversion times of the LCR-6100.
LcrCapabilities capabilities();

}  // namespace lcrig::lcr6100
