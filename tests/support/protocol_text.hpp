// SPDX-License-Identifier: Apache-2.0
// The text of a protocol: as it is shipped, and with a part of it replaced.
#pragma once

#include <stdexcept>
#include <string>

#include "base/strict_json.hpp"

namespace lcrig {

inline std::string library(const std::string& name) {
  return read_text_file("protocols/library/" + name + ".json").value();
}

// Throws when there is no `from`: the test would not test what it says.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::invalid_argument("not in the text: " + from);
  return text.replace(at, from.size(), to);
}

}  // namespace lcrig
