// SPDX-License-Identifier: Apache-2.0
// An answer as the row that it is stored in.
#pragma once

#include "events/payloads.hpp"
#include "protocols/question.hpp"

namespace lcrig {

// `repeat`: of the outermost loop around the question; 0: none.
AnswerEvent answer_event(const Question& question, const GivenAnswer& answer, std::int64_t repeat);

}  // namespace lcrig
