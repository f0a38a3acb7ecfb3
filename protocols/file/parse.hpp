// SPDX-License-Identifier: Apache-2.0
// Reads a protocol file, `load-protocol/1` (docs/protocol-file.md), strictly. Used by the command
// line, the daemon and tables of runs.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>

#include "base/result.hpp"
#include "protocols/protocol.hpp"

namespace lcrig {

// `name` is the text's name in messages (a path). Errors: invalid_request, "FILE:LINE:COL
// /json/pointer: what was found, what was expected".
Result<Protocol> parse_protocol(std::string_view text, const std::string& name);
// Reads the file, then parses it. Errors: also io.
Result<Protocol> load_protocol(const std::string& path);

// Values of parameters by name: a number in the unit of the name's suffix, or the text that a
// person typed.
using ParameterValues = std::map<std::string, std::variant<double, std::string>>;
// The parameters' defaults, replaced by `overrides`. Errors: invalid_request for an unknown name, a
// text that is no number, a fraction where a count is needed, a value out of range.
Result<Environment> bind_parameters(const Protocol& protocol, const ParameterValues& overrides);

}  // namespace lcrig
