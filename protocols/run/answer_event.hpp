// SPDX-License-Identifier: Apache-2.0
// Turns an answer into the event row that it is stored in. Questions uses it.
#pragma once

#include "events/payloads.hpp"
#include "protocols/question.hpp"

namespace lcrig {

// `repeat`: of the outermost loop around the question; 0: none.
AnswerEvent answer_event(const Question& question, const GivenAnswer& answer, std::int64_t repeat);

}  // namespace lcrig
