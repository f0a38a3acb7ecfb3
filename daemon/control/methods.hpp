// SPDX-License-Identifier: Apache-2.0
// The methods of the control socket: a name, and what it calls. dispatch.cpp has those of runs,
// dispatch_queue.cpp those of the queue.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "daemon/control/handler.hpp"

namespace lcrig {

// Answer of a method: its result, or the error as JSON-RPC knows it.
using MethodAnswer = Task<tl::expected<nlohmann::json, RpcError>>;

struct ControlMethod {
  std::string_view name;
  MethodAnswer (*run)(ControlHandler&, nlohmann::json, PeerCredentials);
  const char* hint;  // when the handler calls the request invalid
};
std::span<const ControlMethod> queue_methods();

tl::unexpected<RpcError> refused(const Error& error);
tl::unexpected<RpcError> bad_params(const Error& error);
nlohmann::json answer_of(const char* key, nlohmann::json value);
// The params of a method that takes none, or one text.
Result<> no_params(const nlohmann::json& params);
Result<std::string> one_text(const nlohmann::json& params, const char* key, bool required,
                             std::size_t most);

}  // namespace lcrig
