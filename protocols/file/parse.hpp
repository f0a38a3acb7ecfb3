// SPDX-License-Identifier: Apache-2.0
// Reads a protocol file, `load-protocol/1` (docs/protocol-file.md), strictly. Command line, daemon
// and tables of runs use it.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>

#include "base/result.hpp"
#include "protocols/protocol.hpp"

namespace lcrig {

// `name` is what messages call the text (a path). Errors: invalid_request,
// "FILE:LINE:COL /json/pointer: what was found, what was expected".
Result<Protocol> parse_protocol(std::string_view text, const std::string& name);
// Reads the file first. Errors: also io.
Result<Protocol> load_protocol(const std::string& path);

// Values of parameters by name, in the unit of the name's suffix: a number, or what somebody typed.
using ParameterValues = std::map<std::string, std::variant<double, std::string>>;
// Defaults, replaced by `overrides`. Errors: invalid_request for an unknown name, no number, a
// fraction of a count, out of range.
Result<Environment> bind_parameters(const Protocol& protocol, const ParameterValues& overrides);

}  // namespace lcrig
