// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/commands.hpp"

namespace lcrig::cli {

std::vector<std::unique_ptr<Command>> make_commands() {
  constexpr std::unique_ptr<Command> (*kFactories[])() = {
      make_run_command,           make_rehearse_command,      make_status_command,
      make_watch_command,         make_pause_command,         make_resume_command,
      make_abort_command,         make_freeze_command,        make_confirm_command,
      make_protocol_list_command, make_protocol_show_command, make_protocol_check_command,
      make_protocol_plan_command, make_specimen_add_command,  make_specimen_list_command,
      make_specimen_show_command, make_runs_list_command,     make_runs_show_command,
      make_runs_note_command,     make_export_command,        make_analyze_command,
      make_report_command,        make_budget_command,        make_verify_command,
      make_model_curve_command,   make_model_design_command,  make_model_ladder_command,
      make_model_compare_command, make_model_fit_command,
  };
  std::vector<std::unique_ptr<Command>> out;
  for (const auto factory : kFactories) out.push_back(factory());
  return out;
}

}  // namespace lcrig::cli
