// SPDX-License-Identifier: Apache-2.0
// One line of the control socket to one call of the handler and one line back.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/control/handler.hpp"

namespace lcrig {

struct ControlCall {
  ControlCall();
  ~ControlCall();
  ControlCall(ControlCall&&) noexcept;
  ControlCall& operator=(ControlCall&&) noexcept;
  bool wants_answer = false;  // false: a notification, never answered
  std::string method;
  std::unique_ptr<nlohmann::json> id;  // string or number; null without `wants_answer`
  std::unique_ptr<nlohmann::json> params;
};

// A call, or the error line that answers `line`.
tl::expected<ControlCall, std::string> parse_control_call(std::string_view line);

// Runs the call. nullopt for a notification. `handler` outlives the task.
Task<std::optional<std::string>> answer_control_call(ControlHandler& handler, ControlCall call,
                                                     PeerCredentials peer);

}  // namespace lcrig
