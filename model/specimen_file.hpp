// SPDX-License-Identifier: Apache-2.0
// Reads the file format `specimen/1`, which describes a stack. Used by the daemon, by every command
// that takes a specimen, and by benchmarks.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "model/specimen.hpp"

namespace lcrig {

// `source` names the text in messages. The result has passed check_specimen. Errors:
// invalid_request with position, JSON pointer, what was found and what was expected.
Result<Specimen> parse_specimen(std::string_view text, const std::string& source);
// For a file that is brought in: its name must also be one that can be read back
// (base/name_rule.hpp).
Result<Specimen> accept_specimen(std::string_view text, const std::string& source);
// Errors: as accept_specimen, and io.
Result<Specimen> load_specimen(const std::string& path);

// The specimens that ship with the program, by name: paper-1, paper-2, paper-3.
struct ShippedSpecimen {
  std::string_view name, text;
};
const std::vector<ShippedSpecimen>& shipped_specimens();

}  // namespace lcrig
