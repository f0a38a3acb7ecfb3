// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/queue_source.hpp"

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "daemon/control/queue_messages.hpp"
#include "daemon/queue/pages.hpp"
#include "storage/writer_lock.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

constexpr Duration kPatience = std::chrono::seconds(30);

Outcome<json> list_by(ControlClient& client) {
  auto answer = client.call("status", json::object());
  if (!answer) return answer.error();
  if (auto status = parse_daemon_status(*answer); !status) return Failure(status.error());
  json entries = json::array();
  for (;;) {  // one answer has room for a few hundred entries
    auto page = client.call("queue.list", json{{"skip", entries.size()}});
    if (!page) return page.error();
    const json& some = page->at("entries");
    for (const json& entry : some) entries.push_back(entry);
    if (some.empty() || entries.size() >= page->at("count").get<std::size_t>()) break;
  }
  return json{{"queue", answer->at("queue")}, {"entries", std::move(entries)}};
}

// Removes the planned times, because nobody knows when a daemon will run again.
json without_times(const ListedEntry& entry) {
  json out = to_json(entry);
  out["planned_begin_unix_ns"] = out["planned_end_unix_ns"] = nullptr;
  return out;
}

Outcome<json> list_from(const Database& db) {
  auto status = read_queue_at_rest(db);
  if (!status) return Failure(status.error());
  json entries = json::array();
  for (std::int64_t skip = 0; skip < status->count;) {
    auto page = read_queue_page(db, 0, 0, skip, kQueuePageMax);
    if (!page) return Failure(page.error());
    if (page->entries.empty()) break;
    for (const ListedEntry& entry : page->entries) entries.push_back(without_times(entry));
    skip += static_cast<std::int64_t>(page->entries.size());
  }
  return json{{"queue", to_json(*status)}, {"entries", std::move(entries)}};
}

}  // namespace

Outcome<QueueSource> QueueSource::open(const Context& context) {
  auto client = ControlClient::connect(context);
  if (client) return QueueSource(std::move(*client));
  if (!client.error().no_daemon) return client.error();
  auto chosen = context.database();
  if (!chosen) return chosen.error();
  std::error_code unknown;
  const bool there = std::filesystem::exists(chosen->path, unknown);
  if (!there && !unknown) return client.error();  // the connection's error says more than silence
  auto db = open_runs(context);
  if (!db) return db.error();
  if (!get_queue_state(*db)) return client.error();  // database of an lcrig without a queue
  return QueueSource(std::move(*db), has_writer(chosen->path).value_or(false));
}

Outcome<json> QueueSource::list() {
  if (auto* client = std::get_if<ControlClient>(&from_)) return list_by(*client);
  return list_from(std::get<Database>(from_));
}

Outcome<json> QueueSource::show(std::int64_t entry) {
  if (auto* client = std::get_if<ControlClient>(&from_)) {
    return client->call("queue.show", json{{"entry", entry}}, kPatience);
  }
  auto found = read_listed_entry(std::get<Database>(from_), 0, 0, entry);
  if (!found) return Failure(found.error());
  return without_times(*found);
}

Outcome<json> QueueSource::history(std::optional<std::int64_t> entry, std::int64_t most) {
  if (auto* client = std::get_if<ControlClient>(&from_)) {
    json params{{"most", most}};
    if (entry) params["entry"] = *entry;
    return client->call("queue.history", params, kPatience);
  }
  auto acts = queue_history(std::get<Database>(from_), entry, 0, most);
  if (!acts) return Failure(acts.error());
  json out = json::array();
  for (const QueueAct& act : *acts) out.push_back(to_json(act));
  return json{{"acts", out}};
}

}  // namespace lcrig::cli
