// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/methods.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>
#include <type_traits>

#include "base/clock.hpp"
#include "base/text.hpp"
#include "daemon/control/fields.hpp"
#include "daemon/control/queue_handler.hpp"
#include "daemon/control/queue_messages.hpp"
#include "protocols/plan/plan.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

using Answer = tl::expected<json, RpcError>;

tl::unexpected<RpcError> refused(const Error& error) {
  return tl::unexpected(rpc_error_of(error));
}

tl::unexpected<RpcError> bad_params(const Error& error) {
  RpcError out = rpc_error_of(error);
  out.code = rpc_code::kInvalidParams;
  out.hint = "docs/control.md lists the params of each method";
  return tl::unexpected(std::move(out));
}

json result_json(const RunStarted& started) {
  json out{{"run", started.run}};
  if (started.pressure) out["pressure"] = to_json(*started.pressure);
  return out;
}
json result_json(const std::string& text) {
  return text;
}
json result_json(std::int64_t number) {
  return number;
}
json result_json(const std::vector<QueueAct>& acts) {
  json out = json::array();
  for (const QueueAct& act : acts) out.push_back(to_json(act));
  return out;
}
template <class T>
json result_json(const T& message) {
  return to_json(message);
}

template <class T>
Answer answer_of(const Result<T>& result) {
  if (!result) return refused(result.error());
  if constexpr (std::is_void_v<T>) {
    return json::object();
  } else {
    return result_json(*result);
  }
}

// The part of the handler that has this method. nullptr: there is no queue.
template <class Owner, class R, class... Args>
Owner* owner_of(ControlHandler& handler, R (Owner::*)(Args...)) {
  if constexpr (std::is_same_v<Owner, QueueHandler>) return handler.queue();
  if constexpr (std::is_same_v<Owner, RunHandler>) return &handler.runs();
  if constexpr (std::is_same_v<Owner, SteeringHandler>) return &handler.steering();
  if constexpr (std::is_same_v<Owner, StoreHandler>) return &handler.store();
  if constexpr (std::is_same_v<Owner, MeterHandler>) return &handler.meter();
  if constexpr (std::is_same_v<Owner, ControlHandler>) return &handler;
}

// Calls a method with one argument, or with a tuple of them; adds the peer if the method takes it.
template <class Owner, class Method, class... Args>
auto begin_call(Owner& owner, Method method, std::tuple<Args...>& args, PeerCredentials& peer) {
  return std::apply(
      [&](Args&... each) {
        if constexpr (std::is_invocable_v<Method, Owner&, Args..., PeerCredentials>) {
          return (owner.*method)(std::move(each)..., std::move(peer));
        } else {
          return (owner.*method)(std::move(each)...);
        }
      },
      args);
}
template <class Owner, class Method, class Arg>
auto begin_call(Owner& owner, Method method, Arg& arg, PeerCredentials& peer) {
  std::tuple<Arg> args(std::move(arg));
  return begin_call(owner, method, args, peer);
}

// Params read by a function of this file, or parsed by a function of the messages.
template <class T>
Result<T> params_by(void (*read)(ParamsReader&, T&), const json& params) {
  return read_params<T>(params, read);
}
template <class T>
Result<T> params_by(Result<T> (*parse)(const json&), const json& params) {
  return parse(params);
}

// Most methods: reads the params with `parse`, and calls `method` of the handler or the queue.
template <auto parse, auto method>
MethodAnswer call_method(ControlHandler& handler, json params, PeerCredentials peer) {
  auto* const owner = owner_of(handler, method);
  if (owner == nullptr) co_return refused(Error(Errc::unsupported, "there is no queue here"));
  auto args = params_by(parse, params);
  if (!args) co_return bad_params(args.error());
  auto result = co_await begin_call(*owner, method, *args, peer);
  co_return answer_of(result);
}

void no_params(ParamsReader&, std::tuple<>&) {}

void why_param(ParamsReader& in, std::string& why) {
  in.text("why", why, false, kWhyMax);
}

void specimen_params(ParamsReader& in, SpecimenToAdd& out) {
  in.text("text", out.text, true, kControlLineLimit);
  in.boolean("as_stated", out.as_stated);
}

void resume_params(ParamsReader& in, std::tuple<std::optional<std::int64_t>, bool>& out) {
  auto& [run, confirmed] = out;
  in.integer("run", run);
  in.boolean("confirm_specimen", confirmed);
  if (confirmed && !run) in.refuse("confirm_specimen", "needs `run`");
}

// The stop place in member `key`.
std::optional<StopPlace> place_of(ParamsReader& in, const char* key, bool required) {
  std::string word;
  in.text(key, word, required);
  if (word.empty()) return std::nullopt;
  const auto place = parse_word<StopPlace>(word);
  if (!place) {
    in.refuse(key,
              fmt::format("\"{}\", expected one of {}", printable(word, 60), stop_place_words()));
  }
  return place;
}

void stop_params(ParamsReader& in, std::tuple<StopPlace, std::string>& out) {
  const auto after = place_of(in, "after", true);
  in.text("why", std::get<std::string>(out), false, kWhyMax);
  if (after) std::get<StopPlace>(out) = *after;
  if (!after) in.refuse("after", "is empty");
}

void note_params(ParamsReader& in, std::tuple<std::int64_t, std::string>& out) {
  in.integer("run", std::get<std::int64_t>(out), true);
  in.text("text", std::get<std::string>(out), true, kNoteMax);
}

void entry_param(ParamsReader& in, std::int64_t& entry) {
  in.integer("entry", entry, true);
}

using PageParams = std::tuple<std::int64_t, std::int64_t>;
Result<PageParams> page_params(const json& params) {
  auto range = parse_queue_range(params, "skip");
  if (!range) return fail(range.error());
  return PageParams(range->from, range->most);
}

using HistoryParams = std::tuple<std::optional<std::int64_t>, std::int64_t, std::int64_t>;
Result<HistoryParams> history_params(const json& params) {
  auto range = parse_queue_range(params, "before");
  if (!range) return fail(range.error());
  return HistoryParams(range->entry, range->from, range->most);
}

void force_param(ParamsReader& in, bool& force) {
  in.boolean("force", force);
}

void kind_param(ParamsReader& in, CorrectionKind& kind) {
  in.word("kind", kind, true);
}

// Reads "head": the choice for an entry that was interrupted or failed.
void head_param(ParamsReader& in, HeadChoice& out) {
  std::string word(to_string(HeadChoice::none));
  in.text("head", word);
  const auto known = parse_word<HeadChoice>(word);
  if (known) out = *known;
  if (!known) in.refuse("head", "expected resume, repeat or skip");
}

void gate_params(ParamsReader& in, std::tuple<std::string, std::optional<std::int64_t>>& out) {
  in.text("text", std::get<0>(out), true, kNameMax);
  in.integer("entry", std::get<1>(out));
}

// A method whose result the handler has at once.
template <auto look>
MethodAnswer show_now(ControlHandler& handler, json params, PeerCredentials) {
  if (auto ok = params_by(no_params, params); !ok) co_return bad_params(ok.error());
  co_return to_json((handler.*look)());
}

MethodAnswer on_version(ControlHandler& handler, json params, PeerCredentials) {
  if (auto ok = params_by(no_params, params); !ok) co_return bad_params(ok.error());
  co_return handler.status().version;
}

MethodAnswer on_ask(ControlHandler& handler, json params, PeerCredentials peer) {
  if (auto ok = params_by(no_params, params); !ok) co_return bad_params(ok.error());
  auto asked = co_await handler.runs().ask_instruments(std::move(peer));
  if (!asked) co_return refused(asked.error());
  co_return to_json(handler.status());
}

MethodAnswer on_pause(ControlHandler& handler, json params, PeerCredentials peer) {
  ParamsReader in(params, "/params");
  const auto at = place_of(in, "at", false);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) co_return bad_params(ok.error());
  if (at) {
    auto later = co_await handler.steering().pause_at(*at, std::move(peer));
    co_return answer_of(later);
  }
  auto done = co_await handler.steering().pause(std::move(peer));
  co_return answer_of(done);
}

MethodAnswer on_note(ControlHandler& handler, json params, PeerCredentials peer) {
  auto asked = params_by(note_params, params);
  if (!asked) co_return bad_params(asked.error());
  auto& [run, text] = *asked;
  auto noted = co_await handler.store().note_run(run, std::move(text), std::move(peer));
  if (!noted) co_return refused(noted.error());
  co_return result_json(run);
}

MethodAnswer on_tag(ControlHandler& handler, json params, PeerCredentials peer) {
  auto request = parse_tag_request(params);
  if (!request) co_return bad_params(request.error());
  const std::int64_t run = request->run;
  auto tags = co_await handler.store().tag_run(std::move(*request), std::move(peer));
  if (!tags) co_return refused(tags.error());
  json out;
  out["run"] = run;
  out["tags"] = std::move(*tags);
  co_return out;
}

// Adds a hint to an error: the queue, or the disk, needs attention first.
MethodAnswer on_correct(ControlHandler& handler, json params, PeerCredentials peer) {
  const json kind = params.is_object() ? params.value("kind", json()) : json();
  auto answer = co_await call_method<kind_param, &MeterHandler::correct>(handler, params, peer);
  if (answer) co_return answer;
  const auto queue = handler.status().queue;
  RpcError& error = answer.error();
  if (error.errc == Errc::busy && queue && queue->going) {
    error.hint = HintWords{"", "lcrig queue hold", "then make it again"};
  }
  if (error.errc == Errc::io && kind.is_string()) {
    error.hint = HintWords{"see to what the message names, then: ", "", ""};
    error.hint.command = "lcrig lcr correct " + kind.get<std::string>();
  }
  co_return answer;
}

constexpr HintWords kCheck{
    "change what the message names; --dry-run tries it again and moves nothing", "", ""};
constexpr HintWords kLook{"", "lcrig status", "what goes on"};
constexpr HintWords kSeeMeter{"", "lcrig lcr show", "what is known of the meter's corrections"};
constexpr HintWords kSeeQueue{"", "lcrig queue list", "shows what waits, and for what"};
constexpr HintWords kTryIt{
    "change what the message names; lcrig run ... --dry-run tries it and moves nothing", "", ""};
constexpr HintWords kRehearseIt{
    "change what the message names; lcrig rehearse --batch FILE plays it without a rig", "", ""};
constexpr HintWords kRuns{"", "lcrig runs", "lists them"};
constexpr HintWords kRunsThatEnded{"", "lcrig runs", "lists them, with how they ended"};
constexpr HintWords kGoodSpecimen{
    "correct the file; for a good one: ", "lcrig specimen show paper-1", ""};

// A method that a person needs to stop the frame.
constexpr ControlMethod urgent(ControlMethod method) {
  method.urgent = true;
  return method;
}

constexpr ControlMethod kMethods[] = {
    urgent({"status", show_now<&ControlHandler::status>, kLook}),
    {"watch", show_now<&ControlHandler::status>, kLook, nullptr, true},
    {"version", on_version, kLook, "version"},
    {"metrics", call_method<no_params, &ControlHandler::metrics>, kLook, "text"},
    {"config.show", show_now<&ControlHandler::config_view>, kLook},
    {"run.start", call_method<parse_run_request, &RunHandler::start_run>, kCheck},
    {"run.plan", call_method<parse_run_request, &RunHandler::plan_run>, kCheck},
    {"instruments.ask", on_ask, kLook},
    urgent({"run.pause", on_pause, kLook}),
    {"run.resume", call_method<resume_params, &RunHandler::resume>, kLook},
    urgent({"run.stop", call_method<stop_params, &SteeringHandler::stop_after>, kLook}),
    urgent({"run.abort", call_method<why_param, &SteeringHandler::abort>, kLook}),
    urgent({"run.freeze", call_method<why_param, &SteeringHandler::freeze>, kLook}),
    {"run.confirm", call_method<no_params, &SteeringHandler::confirm>, kLook},
    {"run.answer", call_method<parse_answer_request, &SteeringHandler::answer>, kLook},
    {"run.note", on_note, kRunsThatEnded, "run"},
    {"run.tag", on_tag, kRuns},
    {"specimen.add", call_method<specimen_params, &StoreHandler::add_specimen>, kGoodSpecimen,
     "name"},
    {"lcr.correct", on_correct, kSeeMeter},
    {"lcr.show", call_method<no_params, &MeterHandler::look>, kSeeMeter},
    {"queue.add", call_method<parse_queue_add, &QueueHandler::add>, kTryIt},
    {"queue.add_batch", call_method<parse_batch_add, &QueueHandler::add_batch>, kRehearseIt},
    {"queue.list", call_method<page_params, &QueueHandler::list>, kSeeQueue},
    {"queue.show", call_method<entry_param, &QueueHandler::show>, kSeeQueue},
    {"queue.history", call_method<history_params, &QueueHandler::history>, kSeeQueue, "acts"},
    {"queue.move", call_method<parse_queue_move, &QueueHandler::move>, kSeeQueue},
    {"queue.remove", call_method<entry_param, &QueueHandler::remove>, kSeeQueue},
    {"queue.clear", call_method<no_params, &QueueHandler::clear>, kSeeQueue, "removed"},
    urgent({"queue.hold", call_method<why_param, &QueueHandler::hold>, kSeeQueue}),
    {"queue.start", call_method<head_param, &QueueHandler::start>, kSeeQueue},
    {"queue.lock", call_method<why_param, &QueueHandler::lock>, kSeeQueue},
    {"queue.unlock", call_method<force_param, &QueueHandler::unlock>, kSeeQueue},
    {"queue.answer", call_method<gate_params, &QueueHandler::answer>, kSeeQueue}};

}  // namespace

std::span<const ControlMethod> control_methods() {
  return kMethods;
}

const ControlMethod* find_control_method(std::string_view name) {
  const auto* const found = std::ranges::find(kMethods, name, &ControlMethod::name);
  return found == std::end(kMethods) ? nullptr : found;
}

}  // namespace lcrig
