// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "storage/chain.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class VerifyCommand final : public Command {
 public:
  const char* name() const override { return "verify"; }
  const char* summary() const override {
    return "Check that a run's rows are as they were recorded";
  }
  const char* example() const override { return "lcrig verify last"; }
  void declare(ArgumentList& list) override { list.positional("RUN", run_, "A number, or `last`"); }
  Outcome<ExitCode> run(Context& context) override;

 private:
  std::string run_;
};

Outcome<ExitCode> VerifyCommand::run(Context& context) {
  auto db = open_runs(context);
  if (!db) return tl::unexpected(db.error());
  auto number = named_run(*db, run_);
  if (!number) return tl::unexpected(number.error());
  auto report = verify_chain(*db, *number);
  if (!report) return tl::unexpected(Failure(report.error()));
  if (context.global.json) {
    print_json(context.console.out, json{{"run", *number},
                                         {"intact", report->intact},
                                         {"ended", report->ended},
                                         {"links", report->links},
                                         {"rows", report->rows},
                                         {"last_hash", report->last_hash},
                                         {"finding", report->finding}});
    return report->intact ? kOk : kFailed;
  }
  if (!report->intact) {
    return tl::unexpected(Failure(kFailed, fmt::format("run {}: {}", *number, report->finding),
                                  "restore the database from a backup"));
  }
  fmt::print(context.console.out, "run {}: intact, {} rows in {} links{}\nlast hash {}\n", *number,
             report->rows, report->links, report->ended ? "" : ", still open", report->last_hash);
  return kOk;
}

}  // namespace

std::unique_ptr<Command> make_verify_command() {
  return std::make_unique<VerifyCommand>();
}

}  // namespace lcrig::cli
