// SPDX-License-Identifier: Apache-2.0
// Stores what comes from people instead of a run: notes, tags, specimens. It works aside, because
// another program may lock the database for seconds. Owned by App; used by the control socket and
// by parts of App that write notes.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/control/handler.hpp"

namespace lcrig {

class Callers;

class DatabaseWrites final : public StoreHandler {
 public:
  DatabaseWrites(asio::any_io_executor executor, Clock& clock, const std::string& database,
                 Callers& callers)
      : executor_(std::move(executor)), clock_(clock), database_(database), callers_(callers) {}

  // Only one of these works at a time.
  Task<Result<>> note_run(std::int64_t run, std::string text, PeerCredentials peer) override;
  Task<Result<std::vector<std::string>>> tag_run(TagRequest request, PeerCredentials peer) override;
  Task<Result<std::string>> add_specimen(SpecimenToAdd specimen, PeerCredentials peer) override;

  // Adds a note of the daemon itself to each of these runs. If that fails, it is only logged.
  Task<> note(std::vector<std::int64_t> runs, std::string text);

 private:
  template <class Job>
  Task<std::invoke_result_t<Job&>> store(Job job);

  asio::any_io_executor executor_;
  Clock& clock_;
  const std::string& database_;
  Callers& callers_;
  bool storing_ = false;
};

}  // namespace lcrig
