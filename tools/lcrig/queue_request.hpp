// SPDX-License-Identifier: Apache-2.0
// Shared by the commands of the queue: numbers of entries, places, terms, one call to the daemon.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>

#include "tools/lcrig/batch_request.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig::cli {

// Failure: usage. `global`: options for the proposed command.
Outcome<std::int64_t> entry_number(const std::string& text, const GlobalOptions& global);

// --first, --last, --before ENTRY, --after ENTRY.
class PlaceOptions {
 public:
  void declare(ArgumentList& list);
  // Sets "place"; without an option it is the last place. Failure: usage.
  Outcome<bool> put_into(nlohmann::json& params, const GlobalOptions& global) const;
  bool given() const { return first_ || last_ || !before_.empty() || !after_.empty(); }

 private:
  bool first_ = false, last_ = false;
  std::string before_, after_;
};

// The options of `lcrig queue add` for the terms on which an entry waits in the queue.
class TermsOptions {
 public:
  void declare(ArgumentList& list);
  // Adds the members of queue.add. Failure: usage.
  Outcome<bool> put_into(nlohmann::json& params, std::int64_t now_unix_s) const;

 private:
  Outcome<bool> put_times(nlohmann::json& params, std::int64_t now_unix_s) const;
  std::string on_failure_, failures_max_, not_before_, not_after_, between_, probe_, fixture_;
  std::string rest_;
  bool unattended_ = false;
};

// Makes one call. `text` prints its answer for people.
Outcome<ExitCode> call_queue(Context& context, std::string_view method,
                             const nlohmann::json& params,
                             const std::function<void(std::ostream&, const nlohmann::json&)>& text);

// Calls queue.add and prints the result. `request` names the specimen as it was typed. `protocol`
// and `assignments` are words of the command line.
Outcome<ExitCode> queue_run(Context& context, ControlClient& client, const nlohmann::json& params,
                            const RunRequest& request, const std::string& protocol,
                            const std::vector<std::string>& assignments);

// The members of queue.add_batch that come from the table.
nlohmann::json batch_params(const BatchRequest& batch);
// Calls queue.add_batch and prints the result.
Outcome<ExitCode> queue_batch(Context& context, const nlohmann::json& params,
                              const BatchRequest& batch);

}  // namespace lcrig::cli
