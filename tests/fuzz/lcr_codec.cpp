// SPDX-License-Identifier: Apache-2.0
// Bytes from the meter: readings, identity and settings that are read back.
#include <algorithm>
#include <cmath>

#include "drivers/lcr6100/codec.hpp"
#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {

namespace {

using namespace lcr6100;

bool is_sound(const std::optional<double>& value) {
  // a larger value is an overload
  return !value || (std::isfinite(*value) && std::abs(*value) < 9.9e19);
}

// The numbers, written like "+4.64627e-10,+3.88413e-03" and read again, must be the same.
void require_same_numbers(const ReadingLine& reading) {
  if (!reading.primary || !reading.secondary) return;
  const std::string line =
      format_number(*reading.primary) + "," + format_number(*reading.secondary);
  const auto again = parse_reading(line);
  if (!again) {
    // Our format writes three digits of such an exponent; the meter has two.
    const bool tiny = std::min(std::abs(*reading.primary), std::abs(*reading.secondary)) < 1e-99;
    return require(tiny, "our own reading is refused: " + line);
  }
  const double change = std::abs(*again->primary - *reading.primary);
  require(change <= 6e-6 * std::abs(*reading.primary), "the value changed: " + line);
}

void read_reading(std::string_view input) {
  const auto reading = parse_reading(input);
  if (!reading) return require_good_message(reading.error());
  require(reading->numbers >= 1 && reading->numbers <= 4, "no numbers in an accepted reading");
  require(is_sound(reading->primary) && is_sound(reading->secondary), "no finite reading");
  const bool overload = (reading->flags & lcr_flag::kPrimaryOverload) != 0;
  require(overload != reading->primary.has_value(), "neither a value nor an overload");
  const auto values = parse_reading(reading->values);
  require(values && values->primary == reading->primary, "`values` is not what was read");
  require_same_numbers(*reading);
}

void read_identity(std::string_view input) {
  const auto identity = parse_identity(input);
  if (!identity) return require_good_message(identity.error());
  const auto again = parse_identity(identity->text);
  require(again && again->serial == identity->serial, "the identity changed");
}

void read_settings(std::string_view input) {
  LcrSettings wanted;
  wanted.bias = Voltage::from_si(1.5);
  for (const Setting& setting : settings_for(wanted)) {
    if (!matches(setting, input)) continue;
    LcrSettings got = wanted;
    apply(setting, input, got);
    require(std::abs(got.level.si() - wanted.level.si()) <= 1e-3 * wanted.level.si(), "level");
    require(std::abs(got.frequency.si() - wanted.frequency.si()) <= 1e-5 * wanted.frequency.si(),
            "frequency");
    require(std::abs(got.bias->si() - wanted.bias->si()) <= 0.01, "bias");
  }
  const auto number = parse_with_unit(input);
  require(!number || std::isfinite(*number), "a number with a unit that is not finite");
}

}  // namespace

void read_lcr_codec(std::string_view input) {
  read_reading(input);
  read_identity(input);
  read_settings(input);
}

}  // namespace lcrig::fuzz
