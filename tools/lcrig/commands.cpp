// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/commands.hpp"

namespace lcrig::cli {

std::vector<std::unique_ptr<Command>> make_commands() {
  const CommandFactory factories[] = {
      kRunCommand,          kRehearseCommand,      kStatusCommand,       kWatchCommand,
      kPauseCommand,        kResumeCommand,        kAbortCommand,        kFreezeCommand,
      kConfirmCommand,      kAnswerCommand,        kStopCommand,         kQueueAddCommand,
      kQueueListCommand,    kQueueShowCommand,     kQueueMoveCommand,    kQueueRemoveCommand,
      kQueueHoldCommand,    kQueueStartCommand,    kQueueClearCommand,   kQueueHistoryCommand,
      kQueueLockCommand,    kQueueUnlockCommand,   kQueueAnswerCommand,  kProtocolListCommand,
      kProtocolShowCommand, kProtocolCheckCommand, kProtocolPlanCommand, kSpecimenAddCommand,
      kSpecimenListCommand, kSpecimenShowCommand,  kRunsListCommand,     kRunsShowCommand,
      kRunsNoteCommand,     kExportCommand,        kAnalyzeCommand,      kReportCommand,
      kBudgetCommand,       kVerifyCommand,        kModelCurveCommand,   kModelDesignCommand,
      kModelLadderCommand,  kModelCompareCommand,  kModelFitCommand,     kBackupCommand,
      kRestoreCommand,      kDoctorCommand,        kMetricsCommand,
  };
  std::vector<std::unique_ptr<Command>> out;
  for (const auto factory : factories) out.push_back(factory());
  return out;
}

}  // namespace lcrig::cli
