// SPDX-License-Identifier: Apache-2.0
#include "base/number.hpp"

#include <charconv>

#include "base/number.hpp"
#include "base/text.hpp"

namespace lcrig {

using namespace std::string_view_literals;

std::string number_words(std::string_view text, std::string_view unit) {
  for (const auto dash : {"\u2212"sv, "\u2010"sv, "\u2011"sv, "\u2012"sv, "\u2013"sv, "\u2014"sv}) {
    if (!text.starts_with(dash)) continue;
    return "`" + std::string(dash) + "` is no minus sign: the `-` of the keyboard is";
  }
  if (text.starts_with('+') && number_from<double>(text.substr(1))) {
    return "no `+` stands before it";
  }
  double value{};
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  if (r.ec == std::errc::result_out_of_range && r.ptr == text.data() + text.size()) {
    return "it is larger or smaller than any number that can be stored";
  }
  if (!unit.empty() && text.ends_with(unit)) {
    const auto number = trimmed(text.substr(0, text.size() - unit.size()));
    if (number_from<double>(number)) {
      return "its unit is " + std::string(unit) + " anyhow: leave it out";
    }
  }
  return comma_words(text);
}

}  // namespace lcrig
