// SPDX-License-Identifier: Apache-2.0
// One factory per subcommand; commands.cpp lists them.
#pragma once

#include <memory>

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

std::unique_ptr<Command> make_run_command();
std::unique_ptr<Command> make_rehearse_command();
std::unique_ptr<Command> make_status_command();
std::unique_ptr<Command> make_watch_command();
std::unique_ptr<Command> make_pause_command();
std::unique_ptr<Command> make_resume_command();
std::unique_ptr<Command> make_abort_command();
std::unique_ptr<Command> make_freeze_command();
std::unique_ptr<Command> make_confirm_command();
std::unique_ptr<Command> make_protocol_list_command();
std::unique_ptr<Command> make_protocol_show_command();
std::unique_ptr<Command> make_protocol_check_command();
std::unique_ptr<Command> make_protocol_plan_command();
std::unique_ptr<Command> make_specimen_add_command();
std::unique_ptr<Command> make_specimen_list_command();
std::unique_ptr<Command> make_specimen_show_command();
std::unique_ptr<Command> make_runs_list_command();
std::unique_ptr<Command> make_runs_show_command();
std::unique_ptr<Command> make_runs_note_command();
std::unique_ptr<Command> make_export_command();
std::unique_ptr<Command> make_analyze_command();
std::unique_ptr<Command> make_verify_command();
std::unique_ptr<Command> make_report_command();
std::unique_ptr<Command> make_budget_command();
std::unique_ptr<Command> make_model_curve_command();
std::unique_ptr<Command> make_model_design_command();
std::unique_ptr<Command> make_model_ladder_command();
std::unique_ptr<Command> make_model_compare_command();
std::unique_ptr<Command> make_model_fit_command();

}  // namespace lcrig::cli
