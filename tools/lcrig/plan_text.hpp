// SPDX-License-Identifier: Apache-2.0
// Prints a plan for people, for `lcrig protocol plan` and `lcrig run --dry-run`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>

namespace lcrig::cli {

// Which pressure is meant, where probe and disc differ: from the member `pressure` of a plan or of
// the answer to run.start. Prints nothing without it (an older daemon).
void print_pressure(std::ostream& out, const nlohmann::json& message);
// `plan` as made by to_json(Plan). Throws json::exception when it is something else.
void print_plan(std::ostream& out, const nlohmann::json& plan);

}  // namespace lcrig::cli
