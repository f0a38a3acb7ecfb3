// SPDX-License-Identifier: Apache-2.0
#include "daemon/left_motion.hpp"

#include <algorithm>
#include <filesystem>
#include <future>
#include <memory>
#include <system_error>
#include <thread>

#include "protocols/expand.hpp"
#include "protocols/file/parse.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

bool look(const std::string& database) {
  std::error_code unknown;
  if (!std::filesystem::exists(database, unknown) && !unknown) {
    return !require_safe_to_create(database);  // it was moved away, or its disk is not there
  }
  const auto db = open_read_only(database);
  if (!db) return true;
  const auto runs = unfinished_runs(*db);
  if (!runs) return true;
  return std::ranges::any_of(*runs, [&](std::int64_t run) {
    const auto goes_on = is_being_recorded(database, run);
    return !(goes_on && *goes_on) && commanded_frame(*db, run);
  });
}

}  // namespace

bool commanded_frame(const Database& db, std::int64_t run) {
  const auto row = get_run(db, run);
  if (!row) return true;
  const auto protocol = parse_protocol(row->protocol_text, row->protocol_name);
  return !protocol || commands_frame(*protocol);
}

// A disk that does not answer keeps the thread, and the thread keeps what it uses.
bool may_have_left_motion(const std::string& database, Duration patience) {
  const auto told = std::make_shared<std::promise<bool>>();
  auto answer = told->get_future();
  std::thread([told, database] { told->set_value(look(database)); }).detach();
  return answer.wait_for(patience) != std::future_status::ready || answer.get();
}

}  // namespace lcrig
