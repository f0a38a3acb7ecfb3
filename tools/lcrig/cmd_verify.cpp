// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "storage/chain.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
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
    list.positional(kRunWord, run_, "A number, the beginning of its uuid, or `last` (default)",
                    false);
    list.option("--anchor", anchor_, "LINKS:HASH",
                "Of this run, from the journal, an export, a report or `lcrig run`: finds what "
                "somebody cut off or wrote anew");
  }

  Outcome<ExitCode> run(Context& context) override {
    std::optional<Anchor> anchor;
    if (!anchor_.empty()) {
      auto parsed = parse_anchor(anchor_);
      if (!parsed) return Failure(kUsage, parsed.error().what, "lcrig verify --help");
      anchor = *parsed;
    }
    auto run = open_run(context, run_);
    if (!run) return run.error();
    auto report = verify_chain(run->db, run->number, anchor);
    if (!report) return Failure(report.error(), next_after(report.error()));
    if (context.global.json) {
      const auto keep = anchor_of(*report);
      print_json(context.console.out, json{{"run", run->number},
                                           {"intact", report->intact},
                                           {"ended", report->ended},
                                           {"goes_on", report->goes_on},
                                           {"links", report->head.links},
                                           {"rows", report->rows},
                                           {"last_hash", keep ? json(to_hex(keep->hash)) : json()},
                                           {"anchor", keep ? json(to_string(*keep)) : json()},
                                           {"finding", report->finding}});
      return report->intact ? kOk : kFailed;
    }
    if (!report->intact) {
      return broken(context, *run, *report, anchor);
    }
    fmt::print(context.console.out, "run {}: {}, {} rows in {} links\nanchor {}\n", run->number,
               report->ended ? "intact" : "goes on, intact so far", report->rows,
               report->head.links, to_string(report->head));
    return kOk;
  }

 private:
  Failure broken(const Context& context, const NamedRun& run, const ChainReport& report,
                 const std::optional<Anchor>& anchor) const {
    constexpr const char* kRestore = "restore the database from a backup";
    Failure out(kFailed, fmt::format("run {}: {}", run.number, report.finding), kRestore);
    if (report.not_closed) {
      out.next = fmt::format(
          "start lcrigd, which closes a run that a crash cut off, then verify again with --anchor "
          "if the journal has one; else {}",
          kRestore);
    }
    if (!report.other_anchor) return out;
    const auto other = find_run_of(run.db, *anchor);
    if (other && *other && **other != run.number) {
      const auto number = std::to_string(**other);
      out.what =
          fmt::format("run {}: the anchor that was given is that of run {}", run.number, number);
      out.next = next_command(context.global, {"verify", number, "--anchor", anchor_});
    } else {
      out.next = fmt::format("look whether the anchor is that of run {}; if it is: {}", run.number,
                             kRestore);
    }
    return out;
  }

  std::string run_ = "last", anchor_;
};

}  // namespace

const CommandFactory kVerifyCommand = make_command<VerifyCommand>;

}  // namespace lcrig::cli
