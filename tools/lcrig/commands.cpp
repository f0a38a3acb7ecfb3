// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/commands.hpp"

#include "base/doc_page.hpp"
#include "tools/lcrig/argument_table.hpp"

namespace lcrig::cli {

std::vector<std::unique_ptr<Command>> make_commands() {
  const CommandFactory factories[] = {
      kRunCommand,           kRehearseCommand,      kStatusCommand,       kWatchCommand,
      kPauseCommand,         kResumeCommand,        kAbortCommand,        kFreezeCommand,
      kConfirmCommand,       kAnswerCommand,        kStopCommand,         kQueueAddCommand,
      kQueueListCommand,     kQueueShowCommand,     kQueueMoveCommand,    kQueueRemoveCommand,
      kQueueHoldCommand,     kQueueStartCommand,    kQueueClearCommand,   kQueueHistoryCommand,
      kQueueLockCommand,     kQueueUnlockCommand,   kQueueAnswerCommand,  kProtocolListCommand,
      kProtocolShowCommand,  kProtocolCheckCommand, kProtocolPlanCommand, kSpecimenAddCommand,
      kSpecimenCheckCommand, kSpecimenListCommand,  kSpecimenShowCommand, kRunsListCommand,
      kRunsShowCommand,      kRunsNoteCommand,      kRunsTagCommand,      kRunsCopyCommand,
      kExportCommand,        kAnalyzeCommand,       kCompareCommand,      kReportCommand,
      kBudgetCommand,        kVerifyCommand,        kModelCurveCommand,   kModelDesignCommand,
      kModelLadderCommand,   kModelCompareCommand,  kModelFitCommand,     kBackupCommand,
      kRestoreCommand,       kDoctorCommand,        kConfigCheckCommand,  kConfigShowCommand,
      kMetricsCommand,       kLcrCorrectCommand,    kLcrShowCommand,
  };
  std::vector<std::unique_ptr<Command>> out;
  for (const auto factory : factories) out.push_back(factory());
  return out;
}

std::optional<std::string> answer_to_program(const ProcessEnv& env,
                                             const std::vector<std::string>& args) {
  if (args.empty()) return std::nullopt;
  if (args.front() == "__man") return manual_of_commands();
  if (args.front() != "__complete" || args.size() < 2) return std::nullopt;
  return complete(env, {args.begin() + 2, args.end()});  // the words after "--"
}

void declare_global(ArgumentList& list, GlobalOptions& global) {
  const std::string page = doc_page("cli-json");
  const std::string db = "Database file (default: $LCRIG_DB, the daemon's, yours; " + page + ")";
  const std::string as_json = "Print results as JSON (" + page + ")";
  list.option("--db", global.db, kFileWord, db.c_str());
  list.option("--socket", global.socket, {"PATH", Proposes::file}, "The daemon's control socket");
  list.option("--config", global.config, kFileWord,
              "Take both from the daemon's configuration file");
  list.flag("--json", global.json, as_json.c_str());
}

}  // namespace lcrig::cli
