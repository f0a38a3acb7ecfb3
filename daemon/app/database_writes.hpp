// SPDX-License-Identifier: Apache-2.0
// Adds to the database what comes from people and not from a run: notes, tags, specimens. Beside
// the loop of the instruments, because another program may hold the database for seconds. App owns
// it; the control socket and the parts of App that have something to note use it.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/app/callers.hpp"
#include "daemon/control/handler.hpp"

namespace lcrig {

class DatabaseWrites final : public StoreHandler {
 public:
  DatabaseWrites(asio::any_io_executor executor, Clock& clock, const std::string& database,
                 Callers& callers)
      : executor_(std::move(executor)), clock_(clock), database_(database), callers_(callers) {}

  // One of these after the other.
  Task<Result<>> note_run(std::int64_t run, std::string text, PeerCredentials peer) override;
  Task<Result<std::vector<std::string>>> tag_run(TagRequest request, PeerCredentials peer) override;
  Task<Result<std::string>> add_specimen(std::string text, PeerCredentials peer) override;

  // A note of the daemon's own to each of these runs. One that cannot be stored is only logged.
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
