// SPDX-License-Identifier: Apache-2.0
// Parses one line from the control socket, calls the handler, and returns one line as the answer.
// Used by the control sessions.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/control/handler.hpp"

namespace lcrig {

struct ControlCall {
  ControlCall() = default;  // a constructor, since g++ 12 miscompiles aggregates in coroutines
  bool wants_answer = false;  // false: a notification, never answered
  std::string method;
  nlohmann::json id;  // string or number; null without `wants_answer`
  nlohmann::json params = nlohmann::json::object();
};

// A call, or the error line that answers `line`.
tl::expected<ControlCall, std::string> parse_control_call(std::string_view line);

// Executes the call. nullopt for a notification. `handler` must outlive the task.
Task<std::optional<std::string>> answer_control_call(ControlHandler& handler, ControlCall call,
                                                     PeerCredentials peer);

}  // namespace lcrig
