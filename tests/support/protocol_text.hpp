// SPDX-License-Identifier: Apache-2.0
// Texts of protocols for scenario tests: shipped ones, and variants with a part replaced.
#pragma once

#include <stdexcept>
#include <string>

#include "base/strict_json.hpp"

namespace lcrig {

// Loads to 0.5 N with a limit of 1 N, and unloads.
inline constexpr const char* kLoad = R"({ "format": "load-protocol/1", "name": "load",
  "limits": { "force_N": [-0.2, 1.0], "gap_mm": [-1, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 600 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.5 }, "speed_mm_s": 0.01, "timeout_s": 60 },
    { "id": "level", "do": "measure", "count": 20, "within_s": 4 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 2 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";

inline std::string library(const std::string& name) {
  return read_text_file("protocols/library/" + name + ".json").value();
}

// Replaces `from` by `to`. Throws if `from` is not in the text, because the test would then not
// test what it claims.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::invalid_argument("not in the text: " + from);
  return text.replace(at, from.size(), to);
}

}  // namespace lcrig
