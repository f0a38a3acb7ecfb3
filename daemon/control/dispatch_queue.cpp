// SPDX-License-Identifier: Apache-2.0
// The methods of the queue.
#include <array>
#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "base/text.hpp"
#include "daemon/control/methods.hpp"
#include "daemon/control/params.hpp"
#include "daemon/control/queue_handler.hpp"
#include "daemon/control/queue_messages.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

// Params, then a call of the queue, then its answer.
using QueueCall = MethodAnswer (*)(QueueHandler&, json, PeerCredentials);
template <QueueCall call>
MethodAnswer with_queue(ControlHandler& handler, json params, PeerCredentials peer) {
  QueueHandler* queue = handler.queue();
  if (queue == nullptr) co_return refused(Error(Errc::unsupported, "there is no queue here"));
  auto answer = co_await call(*queue, std::move(params), std::move(peer));
  co_return answer;
}

Result<std::int64_t> one_entry(const json& params) {
  std::int64_t entry = 0;
  ParamsReader in(params, "/params");
  in.integer("entry", entry, true);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) return fail(ok.error());
  return entry;
}

MethodAnswer on_add(QueueHandler& queue, json params, PeerCredentials peer) {
  auto wanted = parse_queue_add(params);
  if (!wanted) co_return bad_params(wanted.error());
  auto added = co_await queue.add(std::move(*wanted), std::move(peer));
  if (!added) co_return refused(added.error());
  co_return to_json(*added);
}

MethodAnswer on_add_batch(QueueHandler& queue, json params, PeerCredentials peer) {
  auto wanted = parse_batch_add(params);
  if (!wanted) co_return bad_params(wanted.error());
  auto added = co_await queue.add_batch(std::move(*wanted), std::move(peer));
  if (!added) co_return refused(added.error());
  co_return to_json(*added);
}

MethodAnswer on_list(QueueHandler& queue, json params, PeerCredentials) {
  auto range = parse_queue_range(params, "skip");
  if (!range) co_return bad_params(range.error());
  auto page = co_await queue.list(range->from, range->most);
  if (!page) co_return refused(page.error());
  co_return to_json(*page);
}

MethodAnswer on_show(QueueHandler& queue, json params, PeerCredentials) {
  auto entry = one_entry(params);
  if (!entry) co_return bad_params(entry.error());
  auto found = co_await queue.show(*entry);
  if (!found) co_return refused(found.error());
  co_return to_json(*found);
}

MethodAnswer on_history(QueueHandler& queue, json params, PeerCredentials) {
  auto range = parse_queue_range(params, "before");
  if (!range) co_return bad_params(range.error());
  auto acts = co_await queue.history(range->entry, range->from, range->most);
  if (!acts) co_return refused(acts.error());
  json out = json::array();
  for (const QueueAct& act : *acts) out.push_back(to_json(act));
  co_return answer_of("acts", std::move(out));
}

MethodAnswer on_move(QueueHandler& queue, json params, PeerCredentials peer) {
  auto wanted = parse_queue_move(params);
  if (!wanted) co_return bad_params(wanted.error());
  auto done = co_await queue.move(wanted->entry, wanted->place, std::move(peer));
  if (!done) co_return refused(done.error());
  co_return json::object();
}

MethodAnswer on_remove(QueueHandler& queue, json params, PeerCredentials peer) {
  auto entry = one_entry(params);
  if (!entry) co_return bad_params(entry.error());
  auto done = co_await queue.remove(*entry, std::move(peer));
  if (!done) co_return refused(done.error());
  co_return json::object();
}

MethodAnswer on_clear(QueueHandler& queue, json params, PeerCredentials peer) {
  if (auto ok = no_params(params); !ok) co_return bad_params(ok.error());
  auto removed = co_await queue.clear(std::move(peer));
  if (!removed) co_return refused(removed.error());
  co_return answer_of("removed", *removed);
}

template <Task<Result<>> (QueueHandler::*method)(std::string, PeerCredentials)>
MethodAnswer on_why(QueueHandler& queue, json params, PeerCredentials peer) {
  auto why = one_text(params, "why", false, kWhyMax);
  if (!why) co_return bad_params(why.error());
  auto done = co_await (queue.*method)(std::move(*why), std::move(peer));
  if (!done) co_return refused(done.error());
  co_return json::object();
}

MethodAnswer on_unlock(QueueHandler& queue, json params, PeerCredentials peer) {
  bool force = false;
  ParamsReader in(params, "/params");
  in.boolean("force", force);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) co_return bad_params(ok.error());
  auto done = co_await queue.unlock(force, std::move(peer));
  if (!done) co_return refused(done.error());
  co_return json::object();
}

// "head": what becomes of an entry that was interrupted or failed.
Result<HeadChoice> head_choice(const json& params) {
  std::string word(to_string(HeadChoice::none));
  ParamsReader in(params, "/params");
  in.text("head", word);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) return fail(ok.error());
  for (const auto choice :
       {HeadChoice::none, HeadChoice::resume, HeadChoice::repeat, HeadChoice::skip}) {
    if (word == to_string(choice)) return choice;
  }
  return fail(Errc::invalid_request, "/params/head: expected resume, repeat or skip");
}

MethodAnswer on_start(QueueHandler& queue, json params, PeerCredentials peer) {
  auto choice = head_choice(params);
  if (!choice) co_return bad_params(choice.error());
  auto done = co_await queue.start(*choice, std::move(peer));
  if (!done) co_return refused(done.error());
  co_return json::object();
}

MethodAnswer on_answer(QueueHandler& queue, json params, PeerCredentials peer) {
  std::string text;
  std::optional<std::int64_t> entry;
  ParamsReader in(params, "/params");
  in.text("text", text, true, kNameMax);
  if (in.member("entry") != nullptr) in.integer("entry", entry.emplace());
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) co_return bad_params(ok.error());
  auto done = co_await queue.answer(std::move(text), entry, std::move(peer));
  if (!done) co_return refused(done.error());
  co_return json::object();
}

constexpr const char* kSeeQueue = "lcrig queue list   (shows what waits, and for what)";
constexpr const char* kTryIt =
    "change what the message names; lcrig run ... --dry-run tries it and moves nothing";

constexpr const char* kRehearseIt =
    "change what the message names; lcrig rehearse --batch FILE plays it without a rig";

constexpr std::array<ControlMethod, 13> kQueueMethods{
    {{"queue.add", with_queue<on_add>, kTryIt},
     {"queue.add_batch", with_queue<on_add_batch>, kRehearseIt},
     {"queue.list", with_queue<on_list>, kSeeQueue},
     {"queue.show", with_queue<on_show>, kSeeQueue},
     {"queue.history", with_queue<on_history>, kSeeQueue},
     {"queue.move", with_queue<on_move>, kSeeQueue},
     {"queue.remove", with_queue<on_remove>, kSeeQueue},
     {"queue.clear", with_queue<on_clear>, kSeeQueue},
     {"queue.hold", with_queue<on_why<&QueueHandler::hold>>, kSeeQueue},
     {"queue.start", with_queue<on_start>, kSeeQueue},
     {"queue.lock", with_queue<on_why<&QueueHandler::lock>>, kSeeQueue},
     {"queue.unlock", with_queue<on_unlock>, kSeeQueue},
     {"queue.answer", with_queue<on_answer>, kSeeQueue}}};

}  // namespace

std::span<const ControlMethod> queue_methods() {
  return kQueueMethods;
}

}  // namespace lcrig
