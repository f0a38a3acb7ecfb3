// SPDX-License-Identifier: Apache-2.0
// The queue at a glance, as part of the daemon's status and as a notification.
#include <nlohmann/json.hpp>

#include "base/enum_words.hpp"
#include "daemon/control/messages.hpp"
#include "daemon/control/params.hpp"

namespace lcrig {

using nlohmann::json;

json to_json(const QueueStatus& q) {
  json out{{"going", q.going},
           {"cause", q.cause ? to_string(*q.cause) : ""},
           {"why", q.why},
           {"count", q.count},
           {"gate", q.gate ? to_string(*q.gate) : ""},
           {"entry", nullptr},
           {"prompt", q.prompt},
           {"locked_by", q.locked_by}};
  if (q.entry) out["entry"] = *q.entry;
  return out;
}

namespace {

// A word that may be missing: then it is empty.
template <class E>
void read_optional_word(ParamsReader& in, const char* key, E last, std::optional<E>& out) {
  std::string word;
  in.text(key, word);
  out = parse_word(word, last);
  if (out || word.empty()) return;
  in.fail_with(Error(Errc::garbled, in.pointer(key) + ": unknown word"));
}

}  // namespace

Result<QueueStatus> parse_queue_status(const json& value) {
  QueueStatus q;
  ParamsReader in(value, "/queue");
  in.boolean("going", q.going);
  read_optional_word(in, "cause", HoldCause::bug, q.cause);
  in.text("why", q.why);
  in.integer("count", q.count);
  if (in.member("entry") != nullptr) in.integer("entry", q.entry.emplace());
  read_optional_word(in, "gate", QueueGate::time, q.gate);
  in.text("prompt", q.prompt);
  in.text("locked_by", q.locked_by);
  if (auto done = in.finish(); !done) return fail(done.error());
  return q;
}

}  // namespace lcrig
