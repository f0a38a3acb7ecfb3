// SPDX-License-Identifier: Apache-2.0
#include "protocols/file/meter_text.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/near_word.hpp"
#include "base/number.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "base/units.hpp"

namespace lcrig {

namespace {

using nlohmann::json;

// Replaces a key and its value, which must be a number or a word.
void replace_member(std::string& text, const JsonDocument& document, const std::string& pointer,
                    const std::string& member) {
  const std::size_t key = byte_of(text, document.key_position(pointer));
  const std::size_t value = byte_of(text, document.value_position(pointer));
  const std::size_t end =
      text[value] == '"' ? text.find('"', value + 1) + 1 : text.find_first_of(",}/ \t\r\n", value);
  text.replace(key, end - key, member);
}

// Writes `member` in place of the key that begins with `stem`. The key may have another unit:
// "frequency_kHz" becomes "frequency_Hz".
Result<> change(std::string& text, const std::string& name, const std::string& stem,
                const std::string& member) {
  const auto document = JsonDocument::parse(text, name);
  if (!document) return fail(document.error());
  const json::json_pointer place("/sample/lcr");
  const json& root = document->root();
  if (!root.contains(place) || !root[place].is_object()) return {};
  for (const auto& [key, value] : root[place].items()) {
    if (!key.starts_with(stem)) continue;
    replace_member(text, *document, "/sample/lcr/" + key, member);
    break;
  }
  return {};
}

// Understands "1kHz" as a number with its unit.
std::optional<double> in_hertz(const std::string& typed) {
  const auto digit = typed.find_last_of("0123456789.");
  if (digit == typed.npos) return std::nullopt;
  const auto number = number_from<double>(typed.substr(0, digit + 1));
  const Unit* unit = find_unit(trimmed(std::string_view(typed).substr(digit + 1)));
  if (!number || unit == nullptr || unit->dimension != Dimension::frequency) return std::nullopt;
  return *number * unit->to_si;
}

// The value as it will stand in the protocol's text. A value that a person typed is kept as typed.
Result<std::string> frequency_literal(const ParameterValues::mapped_type& value) {
  const auto* const typed = std::get_if<std::string>(&value);
  if (typed == nullptr) return fmt::format("{}", std::get<double>(value));
  if (json::parse(*typed, nullptr, false).is_number()) return *typed;
  if (const auto comma = comma_words(*typed); !comma.empty()) {
    return fail(Errc::invalid_request, "frequency_Hz: \"{}\" is no number: {}",
                printable(*typed, 60), comma);
  }
  const auto Hz = in_hertz(*typed);
  return fail(Errc::invalid_request,
              "frequency_Hz: \"{}\" is no number, expected a frequency in Hz{}",
              printable(*typed, 60), Hz ? fmt::format(": {}", *Hz) : std::string());
}

Result<std::string> aperture_literal(const ParameterValues::mapped_type& value) {
  const auto* const word = std::get_if<std::string>(&value);
  const std::string typed = word != nullptr ? *word : fmt::format("{}", std::get<double>(value));
  // Checked here, because the parser would show a line that the file does not have.
  std::vector<std::string> known = all_words<Aperture>();
  known.emplace_back(kAutoAperture);
  if (std::ranges::find(known, typed) != known.end()) return json(typed).dump();
  const auto guess = or_comma(did_you_mean(typed, known));
  return fail(Errc::invalid_request, "aperture: \"{}\"{} expected one of {}", printable(typed, 60),
              guess, fmt::join(known, ", "));
}

}  // namespace

Result<std::string> with_meter_values(std::string_view text, const std::string& name,
                                      ParameterValues& values, MeterValue* wrong) {
  if (wrong != nullptr) *wrong = MeterValue::none;
  const auto document = JsonDocument::parse(text, name);
  if (!document) return fail(document.error());
  // A duplicate key is ambiguous; the parser refuses such a text.
  if (!document->duplicates().empty()) return std::string(text);
  const json& root = document->root();
  std::string out(text);
  for (const std::string what : {"frequency_Hz", "aperture"}) {
    const auto value = values.find(what);
    const json::json_pointer own("/parameters/" + what);
    if (value == values.end() || root.contains(own)) continue;
    const bool number = what != "aperture";
    const auto literal =
        number ? frequency_literal(value->second) : aperture_literal(value->second);
    if (!literal && wrong != nullptr) {
      *wrong = number ? MeterValue::frequency : MeterValue::aperture;
    }
    if (!literal) return fail(literal.error());
    const std::string member = fmt::format(R"("{}": {})", what, *literal);
    if (auto ok = change(out, name, number ? "frequency_" : what, member); !ok) {
      return fail(ok.error());
    }
    values.erase(value);
  }
  return out;
}

}  // namespace lcrig
