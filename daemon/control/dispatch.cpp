// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/dispatch.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "base/clock.hpp"
#include "base/text.hpp"
#include "daemon/control/limits.hpp"
#include "daemon/control/methods.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

std::vector<std::string_view> method_names() {
  std::vector<std::string_view> names;
  std::ranges::transform(control_methods(), std::back_inserter(names), &ControlMethod::name);
  return names;
}

std::string refuse(const json& id, const std::string& why) {
  return error_line(id, RpcError(rpc_code::kInvalidRequest, why,
                                 "one JSON-RPC 2.0 request per line; see docs/control.md"));
}

// A line has more values, or deeper nesting, than a message may have.
struct TooMuch : std::length_error {
  using std::length_error::length_error;
};

// Throws TooMuch at the first excess value, and nlohmann's exceptions.
json parse_limited(std::string_view line) {
  using Event = json::parse_event_t;
  std::size_t values = 0;
  const auto count = [&values](int depth, Event event, const json&) {
    if (event == Event::key || event == Event::object_end || event == Event::array_end) return true;
    if (event != Event::value && depth >= static_cast<int>(kControlDepthMax)) {
      throw TooMuch(
          fmt::format("more than {} objects and arrays inside each other", kControlDepthMax));
    }
    if (++values > kControlValuesMax) {
      throw TooMuch(fmt::format("more than {} values in one message", kControlValuesMax));
    }
    return true;
  };
  return json::parse(line, count);
}

// JSON-RPC allows null as an id but discourages it; here it is refused.
tl::expected<ControlCall, std::string> call_of(json&& message) {
  if (message.is_array()) return tl::unexpected(refuse(nullptr, "batches are not supported"));
  if (!message.is_object()) return tl::unexpected(refuse(nullptr, "a request is a JSON object"));
  ControlCall call;
  if (const auto id = message.find("id"); id != message.end()) {
    if (!id->is_string() && !id->is_number()) {
      return tl::unexpected(refuse(nullptr, "/id: expected a string or a number"));
    }
    call.id = *id;
    call.wants_answer = true;
  }
  const auto version = message.find("jsonrpc");
  if (version == message.end() || *version != "2.0") {
    return tl::unexpected(refuse(call.id, "/jsonrpc: expected \"2.0\""));
  }
  const auto method = message.find("method");
  if (method == message.end() || !method->is_string()) {
    return tl::unexpected(refuse(call.id, "/method: expected a string"));
  }
  call.method = method->get<std::string>();
  if (const auto params = message.find("params"); params != message.end()) {
    call.params = std::move(*params);
  }
  return call;
}

}  // namespace

tl::expected<ControlCall, std::string> parse_control_call(std::string_view line) {
  try {
    return call_of(parse_limited(line));
  } catch (const TooMuch& e) {
    return tl::unexpected(refuse(nullptr, e.what()));
  } catch (const json::parse_error& e) {
    return tl::unexpected(
        error_line(nullptr, RpcError(rpc_code::kParseError,
                                     fmt::format("not JSON: error at byte {} of the line", e.byte),
                                     "one JSON-RPC 2.0 request per line; see docs/control.md")));
  } catch (const json::exception& e) {  // a number out of range
    return tl::unexpected(error_line(
        nullptr,
        RpcError(rpc_code::kParseError, fmt::format("not JSON: {}", printable(e.what(), 200)),
                 "see docs/control.md")));
  }
}

Task<std::optional<std::string>> answer_control_call(ControlHandler& handler, ControlCall call,
                                                     PeerCredentials peer) {
  const ControlMethod* const method = find_control_method(call.method);
  std::string line;
  if (method == nullptr) {
    line =
        error_line(call.id, RpcError(rpc_code::kMethodNotFound,
                                     fmt::format("unknown method '{}'", printable(call.method, 60)),
                                     fmt::format("methods: {}", fmt::join(method_names(), ", "))));
  } else {
    auto answer = co_await method->run(handler, std::move(call.params), std::move(peer));
    if (!answer && answer.error().code == rpc_code_of(Errc::invalid_request)) {
      answer.error().hint = method->hint;
    }
    if (answer && method->member != nullptr) {
      *answer = json::object({{method->member, std::move(*answer)}});
    }
    line = answer ? answer_line(call.id, *answer) : error_line(call.id, answer.error());
  }
  if (!call.wants_answer) co_return std::nullopt;
  co_return line;
}

}  // namespace lcrig
