// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "base/key_words.hpp"
#include "base/near_word.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig {

namespace {

std::string unit_word(const std::string& name) {
  const KeyParts key = split_key(name);
  if (key.unit == nullptr || key.dimension() == Dimension::none) return {};
  return " " + for_people(*key.unit);
}

// Explains why "1,5", "−1" or "2N" is no number, although people write numbers so.
std::string reason(const std::string& name, const std::string* text) {
  if (text == nullptr) return "";
  const auto words = number_words(*text);
  if (!words.empty()) return ": " + words;
  const auto digit = text->find_last_of("0123456789.");
  if (digit == text->npos || digit + 1 == text->size()) return "";
  const auto number = text->substr(0, digit + 1), unit = text->substr(digit + 1);
  if (!number_from<double>(number) || find_unit(unit) == nullptr) return "";
  const auto own = unit_word(name);
  return own.empty() ? ": it has no unit" : fmt::format(": its unit is{}, by its name", own);
}

using ParameterValue = ParameterValues::mapped_type;

Result<double> read_override(const std::string& name, const Parameter& p,
                             const ParameterValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  const std::string shown =
      text != nullptr ? printable(*text, 60) : fmt::format("{}", std::get<double>(value));
  const auto number = text != nullptr ? number_from<double>(*text) : std::get<double>(value);
  if (!number || !std::isfinite(*number)) {
    return fail(Errc::invalid_request,
                "parameter {}: \"{}\" is no number{}, expected a number from {} to {}{}", name,
                shown, reason(name, text), p.min, p.max, unit_word(name));
  }
  const double v = *number;
  if (p.integer && v != std::floor(v)) {
    return fail(Errc::invalid_request,
                "parameter {}: {} is a fraction, expected a whole number from {} to {}", name,
                shown, p.min, p.max);
  }
  if (v < p.min || v > p.max) {
    return fail(Errc::invalid_request, "parameter {}: {} is out of range, expected {} to {}{}",
                name, shown, p.min, p.max, unit_word(name));
  }
  return v;
}

}  // namespace

Result<Environment> bind_parameters(const Protocol& protocol, const ParameterValues& overrides) {
  Environment env;
  std::vector<std::string> known;
  std::string list;
  for (const auto& [name, p] : protocol.parameters) {
    env.set(name, p.default_value * p.to_si);
    known.push_back(name);
    list += (list.empty() ? "" : ", ") + name;
  }
  for (const auto& [name, value] : overrides) {
    const auto it = protocol.parameters.find(name);
    if (it == protocol.parameters.end()) {
      if (const auto unit = unit_mistake(name, known)) {
        return fail(Errc::invalid_request, "{}: parameter {}", protocol.name, *unit);
      }
      const auto guess = or_comma(guess_words(nearest_key(name, known)));
      return fail(Errc::invalid_request, "{} has no parameter `{}`{} it has: {}", protocol.name,
                  printable(name, 60), guess, list.empty() ? "none" : printable(list, 1000));
    }
    const auto v = read_override(name, it->second, value);
    if (!v) return fail(v.error());
    env.set(name, *v * it->second.to_si);
  }
  return env;
}

}  // namespace lcrig
