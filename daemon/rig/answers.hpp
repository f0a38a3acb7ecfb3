// SPDX-License-Identifier: Apache-2.0
// Reads the file format `answers/1` (docs/protocol-file.md): the answers of a rehearsal to the
// questions of a protocol. Used by the simulated person.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "protocols/protocol.hpp"
#include "protocols/question.hpp"

namespace lcrig {

using Answers = std::map<std::string, AnswerValue>;  // by step id

// `name` is the text's name in messages. Errors: invalid_request with position and JSON pointer for
// an unknown step or an answer that does not fit.
Result<Answers> parse_answers(std::string_view text, const std::string& name,
                              const Protocol& protocol, const Environment& environment);

}  // namespace lcrig
