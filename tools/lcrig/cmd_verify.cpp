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
  VerifyCommand()
      : Command("verify", "Check that a run's rows are as they were recorded",
                "lcrig verify last") {}
  void declare(ArgumentList& list) override {
    list.positional("RUN", run_, "A number, or `last` (default)", false);
  }

  Outcome<ExitCode> run(Context& context) override {
    auto run = open_run(context, run_);
    if (!run) return run.error();
    auto report = verify_chain(run->db, run->number);
    if (!report) return Failure(report.error());
    if (context.global.json) {
      print_json(context.console.out, json{{"run", run->number},
                                           {"intact", report->intact},
                                           {"ended", report->ended},
                                           {"links", report->links},
                                           {"rows", report->rows},
                                           {"last_hash", report->last_hash},
                                           {"finding", report->finding}});
      return report->intact ? kOk : kFailed;
    }
    if (!report->intact) {
      return Failure(kFailed, fmt::format("run {}: {}", run->number, report->finding),
                     "restore the database from a backup");
    }
    fmt::print(context.console.out, "run {}: intact, {} rows in {} links{}\nlast hash {}\n",
               run->number, report->rows, report->links, report->ended ? "" : ", still open",
               report->last_hash);
    return kOk;
  }

 private:
  std::string run_ = "last";
};

}  // namespace

const CommandFactory kVerifyCommand = make_command<VerifyCommand>;

}  // namespace lcrig::cli
