// SPDX-License-Identifier: Apache-2.0
// runs copy.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "storage/copy_runs.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/follow_run.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class RunsCopyCommand final : public Command {
 public:
  RunsCopyCommand()
      : Command("runs copy", "Copy whole runs into another database, and check the copies",
                "lcrig runs copy 12 13 --to /media/backup/thesis.db") {}
  void declare(ArgumentList& list) override {
    list.words(kRunWord, runs_, kWhichRun, true);
    list.option("--to", to_, kFileWord, "The other database; made when it is not there", true);
  }

  Outcome<ExitCode> run(Context& context) override {
    std::vector<std::int64_t> numbers;
    {
      auto db = open_runs(context);
      if (!db) return db.error();
      for (const auto& text : runs_) {
        auto number = named_run(context, *db, text);
        if (!number) return number.error();
        numbers.push_back(*number);
      }
    }
    auto from = context.db_path();
    if (!from) return from.error();
    auto copied = copy(context, *from, std::move(numbers));
    if (!copied) return refusal(context, copied.error());
    return tell(context, *copied);
  }

 private:
  Result<std::vector<CopiedRun>> copy(const Context& context, const std::string& from,
                                      std::vector<std::int64_t> numbers) const {
    StopSignals signals;
    RunCopyOptions options;
    options.goes_on = [&signals] { return signals.take() == 0; };
    options.by = login_name();
    options.now_unix_ns = context.clock.unix_ns();
    return copy_runs(from, std::move(numbers), to_, std::move(options));
  }

  Failure refusal(const Context& context, const Error& error) const {
    if (error.database == to_) return Failure(error, "give another --to");
    if (error.code == Errc::invalid_request) {
      return Failure(error, next_command(context.global, {"runs"}, "lists them"));
    }
    Failure out(error, next_after(error, "lcrig runs copy --help"));
    if (error.code == Errc::aborted) out.code = kInterrupted;
    return out;
  }

  ExitCode tell(Context& context, const std::vector<CopiedRun>& copied) const {
    json all{{"file", to_}, {"runs", json::array()}};
    for (const auto& run : copied) {
      all["runs"].push_back(
          json{{"run", run.from}, {"to", run.to}, {"uuid", run.uuid}, {"rows", run.rows}});
    }
    return show(context, all, [&](std::ostream& out) {
      for (const auto& run : copied) {
        fmt::print(out, "run {} is run {} of {}: {}, {} rows checked\n", run.from, run.to,
                   printable(to_), run.uuid, run.rows);
      }
    });
  }

  std::vector<std::string> runs_;
  std::string to_;
};

}  // namespace

const CommandFactory kRunsCopyCommand = make_command<RunsCopyCommand>;

}  // namespace lcrig::cli
