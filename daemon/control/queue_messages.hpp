// SPDX-License-Identifier: Apache-2.0
// Messages about the queue on the control socket; docs/control.md is the contract. Used by the
// daemon and `lcrig queue`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <tuple>

#include "daemon/control/queue_handler.hpp"

namespace lcrig {

nlohmann::json to_json(const EntryPlan& plan);
// Reads a stored plan. Parts that do not parse count as unknown.
EntryPlan parse_entry_plan(std::string_view json_text);
nlohmann::json to_json(const QueueAdded& added);
nlohmann::json to_json(const BatchAdded& added);
nlohmann::json to_json(const ListedEntry& entry);
nlohmann::json to_json(const QueuePage& page);
nlohmann::json to_json(const QueueAct& act);

// Read the params of requests. Errors: invalid_request with the JSON pointer.
Result<QueueAdd> parse_queue_add(const nlohmann::json& params);
Result<BatchAdd> parse_batch_add(const nlohmann::json& params);
using QueueMove = std::tuple<std::int64_t, QueuePlace>;  // an entry and its new place
Result<QueueMove> parse_queue_move(const nlohmann::json& params);
struct QueueRange {
  std::optional<std::int64_t> entry;
  std::int64_t from = 0, most = kQueuePageMax;
};
// `from` is the name of the member with the start of the page.
Result<QueueRange> parse_queue_range(const nlohmann::json& params, const char* from);

}  // namespace lcrig
