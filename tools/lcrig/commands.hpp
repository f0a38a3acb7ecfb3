// SPDX-License-Identifier: Apache-2.0
// One factory per subcommand; commands.cpp lists them.
#pragma once

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

extern const CommandFactory kRunCommand, kRehearseCommand, kStatusCommand, kWatchCommand,
    kPauseCommand, kResumeCommand, kAbortCommand, kFreezeCommand, kConfirmCommand, kAnswerCommand,
    kProtocolListCommand, kProtocolShowCommand, kProtocolCheckCommand, kProtocolPlanCommand,
    kSpecimenAddCommand, kSpecimenCheckCommand, kSpecimenListCommand, kSpecimenShowCommand,
    kRunsListCommand, kRunsShowCommand, kRunsNoteCommand, kRunsTagCommand, kRunsCopyCommand,
    kExportCommand, kAnalyzeCommand, kCompareCommand, kVerifyCommand, kReportCommand,
    kBudgetCommand, kModelCurveCommand, kModelDesignCommand, kModelLadderCommand,
    kModelCompareCommand, kModelFitCommand, kStopCommand, kQueueAddCommand, kQueueListCommand,
    kQueueShowCommand, kQueueMoveCommand, kQueueRemoveCommand, kQueueHoldCommand,
    kQueueStartCommand, kQueueClearCommand, kQueueHistoryCommand, kQueueLockCommand,
    kQueueUnlockCommand, kQueueAnswerCommand, kBackupCommand, kRestoreCommand, kDoctorCommand,
    kMetricsCommand, kConfigCheckCommand, kConfigShowCommand, kLcrCorrectCommand, kLcrShowCommand;

}  // namespace lcrig::cli
