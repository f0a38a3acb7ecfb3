// SPDX-License-Identifier: Apache-2.0
// The queue at a glance, as part of the daemon's status and as a notification.
#include <nlohmann/json.hpp>

#include "daemon/control/messages.hpp"
#include "daemon/control/params.hpp"

namespace lcrig {

using nlohmann::json;

json to_json(const QueueStatus& q) {
  json out{{"going", q.going},   {"cause", q.cause},        {"why", q.why},
           {"count", q.count},   {"gate", q.gate},          {"entry", nullptr},
           {"prompt", q.prompt}, {"locked_by", q.locked_by}};
  if (q.entry) out["entry"] = *q.entry;
  return out;
}

Result<QueueStatus> parse_queue_status(const json& value) {
  QueueStatus q;
  ParamsReader in(value, "/queue");
  in.boolean("going", q.going);
  in.text("cause", q.cause);
  in.text("why", q.why);
  in.integer("count", q.count);
  if (in.member("entry") != nullptr) in.integer("entry", q.entry.emplace());
  in.text("gate", q.gate);
  in.text("prompt", q.prompt);
  in.text("locked_by", q.locked_by);
  if (auto done = in.finish(); !done) return fail(done.error());
  return q;
}

}  // namespace lcrig
