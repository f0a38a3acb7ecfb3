// SPDX-License-Identifier: Apache-2.0
// The file format `specimen/1` (design section 10): what a stack is made of.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "model/specimen.hpp"

namespace lcrig {

// `source` is what messages call the text. The result passed check_specimen. Errors:
// invalid_request with position, JSON pointer, what was found and what was expected.
Result<Specimen> parse_specimen(std::string_view text, const std::string& source);
// Errors: also io.
Result<Specimen> load_specimen(const std::string& path);

// The specimens that ship with the program, by name: paper-1, paper-2, paper-3.
struct ShippedSpecimen {
  std::string_view name, text;
};
const std::vector<ShippedSpecimen>& shipped_specimens();

}  // namespace lcrig
