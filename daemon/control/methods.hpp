// SPDX-License-Identifier: Apache-2.0
// The table of the methods of the control socket: their names and the calls that they make. Used by
// dispatch.cpp.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>
#include <tl/expected.hpp>

#include "daemon/control/handler.hpp"

namespace lcrig {

// What a method returns: its result, or a JSON-RPC error.
using MethodAnswer = Task<tl::expected<nlohmann::json, RpcError>>;

struct ControlMethod {
  std::string_view name;
  MethodAnswer (*run)(ControlHandler&, nlohmann::json, PeerCredentials);
  HintWords hint;  // used when the handler finds the request invalid
  const char* member = nullptr;  // the answer's member for the result; nullptr: the result is the
                                 // answer
  bool watches = false;  // from now on the session sends every change of status to its client
  bool urgent = false;  // a stop, or a look: served also where no other call is
};
std::span<const ControlMethod> control_methods();
const ControlMethod* find_control_method(std::string_view name);  // nullptr: no such method

}  // namespace lcrig
