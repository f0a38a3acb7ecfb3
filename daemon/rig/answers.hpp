// SPDX-License-Identifier: Apache-2.0
// Reads the file format `answers/1` (docs/protocol-file.md): what a rehearsal answers to the
// questions of a protocol. The simulated person uses it.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "protocols/protocol.hpp"
#include "protocols/question.hpp"

namespace lcrig {

using Answers = std::map<std::string, AnswerValue>;  // by the id of the step

// `name` is what messages call the text. Errors: invalid_request with position and JSON pointer: no
// such step, an answer that does not fit.
Result<Answers> parse_answers(std::string_view text, const std::string& name,
                              const Protocol& protocol, const Environment& environment);

}  // namespace lcrig
