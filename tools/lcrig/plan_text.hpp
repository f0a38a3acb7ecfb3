// SPDX-License-Identifier: Apache-2.0
// A plan for people: of `lcrig protocol plan`, and of the daemon for `lcrig run --dry-run`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>

namespace lcrig::cli {

// `plan` as to_json(Plan) makes it. Throws json::exception when it is something else.
void print_plan(std::ostream& out, const nlohmann::json& plan);

}  // namespace lcrig::cli
