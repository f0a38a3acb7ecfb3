// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/dispatch.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "base/clock.hpp"
#include "base/text.hpp"
#include "daemon/control/limits.hpp"
#include "daemon/control/methods.hpp"
#include "daemon/control/params.hpp"

namespace lcrig {

using nlohmann::json;

ControlCall::ControlCall()
    : id(std::make_unique<json>()), params(std::make_unique<json>(json::object())) {}
ControlCall::~ControlCall() = default;
ControlCall::ControlCall(ControlCall&&) noexcept = default;
ControlCall& ControlCall::operator=(ControlCall&&) noexcept = default;

tl::unexpected<RpcError> refused(const Error& error) {
  return tl::unexpected(rpc_error_of(error));
}

tl::unexpected<RpcError> bad_params(const Error& error) {
  RpcError out = rpc_error_of(error);
  out.code = rpc_code::kInvalidParams;
  out.hint = "docs/control.md lists the params of each method";
  return tl::unexpected(std::move(out));
}

json answer_of(const char* key, json value) {
  json out = json::object();
  out[key] = std::move(value);
  return out;
}

Result<> no_params(const json& params) {
  ParamsReader in(params, "/params");
  in.refuse_unknown();
  return in.finish();
}

Result<std::string> one_text(const json& params, const char* key, bool required, std::size_t most) {
  std::string out;
  ParamsReader in(params, "/params");
  in.text(key, out, required, most);
  in.refuse_unknown();
  if (auto done = in.finish(); !done) return fail(done.error());
  return out;
}

namespace {

using Answer = MethodAnswer;

Answer on_status(ControlHandler& handler, json params, PeerCredentials) {
  if (auto ok = no_params(params); !ok) co_return bad_params(ok.error());
  co_return to_json(handler.status());
}

Answer on_version(ControlHandler& handler, json params, PeerCredentials) {
  if (auto ok = no_params(params); !ok) co_return bad_params(ok.error());
  co_return answer_of("version", handler.status().version);
}

Answer on_metrics(ControlHandler& handler, json params, PeerCredentials) {
  if (auto ok = no_params(params); !ok) co_return bad_params(ok.error());
  auto text = co_await handler.metrics();
  if (!text) co_return refused(text.error());
  co_return answer_of("text", *text);
}

Answer on_config(ControlHandler& handler, json params, PeerCredentials) {
  if (auto ok = no_params(params); !ok) co_return bad_params(ok.error());
  co_return to_json(handler.config_view());
}

Answer on_start(ControlHandler& handler, json params, PeerCredentials peer) {
  auto request = parse_run_request(params);
  if (!request) co_return bad_params(request.error());
  auto started = co_await handler.start_run(std::move(*request), std::move(peer));
  if (!started) co_return refused(started.error());
  co_return answer_of("run", started->run);
}

Answer on_plan(ControlHandler& handler, json params, PeerCredentials peer) {
  auto request = parse_run_request(params);
  if (!request) co_return bad_params(request.error());
  auto plan = co_await handler.plan_run(std::move(*request), std::move(peer));
  if (!plan) co_return refused(plan.error());
  co_return to_json(*plan);
}

Answer on_ask(ControlHandler& handler, json params, PeerCredentials peer) {
  if (auto ok = no_params(params); !ok) co_return bad_params(ok.error());
  auto asked = co_await handler.ask_instruments(std::move(peer));
  if (!asked) co_return refused(asked.error());
  co_return to_json(handler.status());
}

// A method that takes no params and answers only that it is done.
template <Task<Result<>> (ControlHandler::*method)(PeerCredentials)>
Answer on_plain(ControlHandler& handler, json params, PeerCredentials peer) {
  if (auto ok = no_params(params); !ok) co_return bad_params(ok.error());
  auto done = co_await (handler.*method)(std::move(peer));
  if (!done) co_return refused(done.error());
  co_return json::object();
}

Answer on_resume(ControlHandler& handler, json params, PeerCredentials peer) {
  ParamsReader in(params, "/params");
  std::optional<std::int64_t> which;
  if (in.member("run") != nullptr) in.integer("run", which.emplace());
  bool confirmed = false;
  in.boolean("confirm_specimen", confirmed);
  if (confirmed && !which) {
    in.fail_with(Error(Errc::invalid_request, "/params/confirm_specimen: needs `run`"));
  }
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) co_return bad_params(ok.error());
  auto going = co_await handler.resume(which, confirmed, std::move(peer));
  if (!going) co_return refused(going.error());
  co_return answer_of("run", going->run);
}

template <Task<Result<StopAnswer>> (ControlHandler::*method)(std::string, PeerCredentials)>
Answer on_stop(ControlHandler& handler, json params, PeerCredentials peer) {
  auto why = one_text(params, "why", false, kWhyMax);
  if (!why) co_return bad_params(why.error());
  auto done = co_await (handler.*method)(std::move(*why), std::move(peer));
  if (!done) co_return refused(done.error());
  co_return to_json(*done);
}

Answer on_answer(ControlHandler& handler, json params, PeerCredentials peer) {
  auto request = parse_answer_request(params);
  if (!request) co_return bad_params(request.error());
  auto answered = co_await handler.answer(std::move(*request), std::move(peer));
  if (!answered) co_return refused(answered.error());
  co_return to_json(*answered);
}

// The place that a member names.
std::optional<StopPlace> place_of(ParamsReader& in, const char* key, bool required) {
  std::string word;
  in.text(key, word, required);
  if (word.empty()) return std::nullopt;
  const auto place = parse_stop_place(word);
  if (!place) {
    in.fail_with(
        Error(Errc::invalid_request, fmt::format("{}: \"{}\", expected one of {}", in.pointer(key),
                                                 printable(word, 60), stop_place_words())));
  }
  return place;
}

Answer on_pause(ControlHandler& handler, json params, PeerCredentials peer) {
  ParamsReader in(params, "/params");
  const auto at = place_of(in, "at", false);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) co_return bad_params(ok.error());
  if (at) {
    auto later = co_await handler.pause_at(*at, std::move(peer));
    if (!later) co_return refused(later.error());
    co_return to_json(*later);
  }
  auto done = co_await handler.pause(std::move(peer));
  if (!done) co_return refused(done.error());
  co_return json::object();
}

Answer on_stop_after(ControlHandler& handler, json params, PeerCredentials peer) {
  std::string why;
  ParamsReader in(params, "/params");
  const auto after = place_of(in, "after", true);
  in.text("why", why, false, kWhyMax);
  in.refuse_unknown();
  if (!after) in.fail_with(Error(Errc::invalid_request, "/params/after: is empty"));
  if (auto ok = in.finish(); !ok) co_return bad_params(ok.error());
  auto later = co_await handler.stop_after(*after, std::move(why), std::move(peer));
  if (!later) co_return refused(later.error());
  co_return to_json(*later);
}

Answer on_note(ControlHandler& handler, json params, PeerCredentials peer) {
  std::int64_t run = 0;
  std::string text;
  ParamsReader in(params, "/params");
  in.integer("run", run, true);
  in.text("text", text, true, kNoteMax);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) co_return bad_params(ok.error());
  auto noted = co_await handler.note_run(run, std::move(text), std::move(peer));
  if (!noted) co_return refused(noted.error());
  co_return answer_of("run", run);
}

Answer on_tag(ControlHandler& handler, json params, PeerCredentials peer) {
  auto request = parse_tag_request(params);
  if (!request) co_return bad_params(request.error());
  const std::int64_t run = request->run;
  auto tags = co_await handler.tag_run(std::move(*request), std::move(peer));
  if (!tags) co_return refused(tags.error());
  json out;
  out["run"] = run;
  out["tags"] = std::move(*tags);
  co_return out;
}

Answer on_add_specimen(ControlHandler& handler, json params, PeerCredentials peer) {
  auto text = one_text(params, "text", true, kControlLineLimit);
  if (!text) co_return bad_params(text.error());
  auto name = co_await handler.add_specimen(std::move(*text), std::move(peer));
  if (!name) co_return refused(name.error());
  co_return answer_of("name", *name);
}

constexpr const char* kCheck =
    "change what the message names; --dry-run tries it again and moves nothing";
constexpr const char* kLook = "lcrig status   (what goes on)";

constexpr std::array<ControlMethod, 18> kMethods{
    {{"status", on_status, kLook},
     {"watch", on_status, kLook},  // the session subscribes
     {"version", on_version, kLook},
     {"metrics", on_metrics, kLook},
     {"config.show", on_config, kLook},
     {"run.start", on_start, kCheck},
     {"run.plan", on_plan, kCheck},
     {"instruments.ask", on_ask, kLook},
     {"run.pause", on_pause, kLook},
     {"run.resume", on_resume, "lcrig status   (what goes on)"},
     {"run.stop", on_stop_after, kLook},
     {"run.abort", on_stop<&ControlHandler::abort>, kLook},
     {"run.freeze", on_stop<&ControlHandler::freeze>, kLook},
     {"run.confirm", on_plain<&ControlHandler::confirm>, kLook},
     {"run.answer", on_answer, kLook},
     {"run.note", on_note, "lcrig runs   (lists them, with how they ended)"},
     {"run.tag", on_tag, "lcrig runs   (lists them)"},
     {"specimen.add", on_add_specimen,
      "correct the file; for a good one: lcrig specimen show paper-1"}}};

// nullptr: there is no such method.
const ControlMethod* find_method(std::string_view name) {
  for (const std::span<const ControlMethod> some :
       {std::span<const ControlMethod>(kMethods), queue_methods()}) {
    const auto found = std::ranges::find(some, name, &ControlMethod::name);
    if (found != some.end()) return &*found;
  }
  return nullptr;
}

std::vector<std::string_view> method_names() {
  std::vector<std::string_view> names;
  std::ranges::transform(kMethods, std::back_inserter(names), &ControlMethod::name);
  std::ranges::transform(queue_methods(), std::back_inserter(names), &ControlMethod::name);
  return names;
}

std::string refuse(const json& id, const std::string& why) {
  return error_line(id, RpcError(rpc_code::kInvalidRequest, why,
                                 "one JSON-RPC 2.0 request per line; see docs/control.md"));
}

// A line holds more values, or deeper ones, than a message may have.
struct TooMuch : std::length_error {
  using std::length_error::length_error;
};

// Throws TooMuch at the first value too many, and what nlohmann throws.
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

// JSON-RPC allows null as an id but calls it a bad idea; we answer nobody we cannot name.
tl::expected<ControlCall, std::string> call_of(json&& message) {
  if (message.is_array()) return tl::unexpected(refuse(nullptr, "batches are not supported"));
  if (!message.is_object()) return tl::unexpected(refuse(nullptr, "a request is a JSON object"));
  ControlCall call;
  if (const auto id = message.find("id"); id != message.end()) {
    if (!id->is_string() && !id->is_number()) {
      return tl::unexpected(refuse(nullptr, "/id: expected a string or a number"));
    }
    *call.id = *id;
    call.wants_answer = true;
  }
  const auto version = message.find("jsonrpc");
  if (version == message.end() || *version != "2.0") {
    return tl::unexpected(refuse(*call.id, "/jsonrpc: expected \"2.0\""));
  }
  const auto method = message.find("method");
  if (method == message.end() || !method->is_string()) {
    return tl::unexpected(refuse(*call.id, "/method: expected a string"));
  }
  call.method = method->get<std::string>();
  if (const auto params = message.find("params"); params != message.end()) {
    *call.params = std::move(*params);
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
  const ControlMethod* method = find_method(call.method);
  std::string line;
  if (method == nullptr) {
    line = error_line(*call.id,
                      RpcError(rpc_code::kMethodNotFound,
                               fmt::format("unknown method '{}'", printable(call.method, 60)),
                               fmt::format("methods: {}", fmt::join(method_names(), ", "))));
  } else {
    auto answer = co_await method->run(handler, std::move(*call.params), std::move(peer));
    if (!answer && answer.error().code == rpc_code_of(Errc::invalid_request)) {
      answer.error().hint = method->hint;
    }
    line = answer ? answer_line(*call.id, *answer) : error_line(*call.id, answer.error());
  }
  if (!call.wants_answer) co_return std::nullopt;
  co_return line;
}

}  // namespace lcrig
