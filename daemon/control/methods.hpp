// SPDX-License-Identifier: Apache-2.0
// The methods of the control socket: the name of each, and the call that it makes. dispatch.cpp
// looks them up.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>
#include <tl/expected.hpp>

#include "daemon/control/handler.hpp"

namespace lcrig {

// Answer of a method: its result, or the error as JSON-RPC knows it.
using MethodAnswer = Task<tl::expected<nlohmann::json, RpcError>>;

struct ControlMethod {
  std::string_view name;
  MethodAnswer (*run)(ControlHandler&, nlohmann::json, PeerCredentials);
  HintWords hint;  // when the handler calls the request invalid
  const char* member = nullptr;  // of the answer, for the result; nullptr: the result alone
  bool watches = false;  // the session sends its client each change of the status from now on
};
std::span<const ControlMethod> control_methods();
const ControlMethod* find_control_method(std::string_view name);  // nullptr: there is none

}  // namespace lcrig
