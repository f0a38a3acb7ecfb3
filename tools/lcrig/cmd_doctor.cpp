// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "base/doc_page.hpp"
#include "base/program_version.hpp"
#include "base/text.hpp"
#include "storage/database.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/doctor.hpp"
#include "tools/lcrig/doctor_bundle.hpp"
#include "tools/lcrig/state_frame.hpp"
#include "tools/lcrig/without_values.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

json findings_json(const Findings& findings) {
  json out{{"health", to_string(worst_of(findings))}, {"findings", json::array()}};
  for (const auto& f : findings) {
    out["findings"].push_back(json{
        {"about", f.about}, {"health", to_string(f.health)}, {"what", f.what}, {"mend", f.mend}});
  }
  return out;
}

void print_findings(std::ostream& out, const Findings& findings) {
  for (const auto& f : findings) {
    fmt::print(out, "{:4}  {:14}  {}{}{}\n", to_string(f.health), f.about, f.what,
               f.mend.empty() ? "" : "; mend it: ", f.mend);
  }
}

// The exit codes that docs/cli-json.md promises for this command.
ExitCode exit_code_of(Health health) {
  return health == Health::ok ? kOk : health == Health::warn ? kFailed : kUsage;
}

class DoctorCommand final : public Command {
 public:
  DoctorCommand()
      : Command("doctor",
                "Look at computer, service, ports and data; what is wrong, how to mend it",
                "lcrig doctor --ask") {}
  void declare(ArgumentList& list) override {
    list.flag("--ask", ask_, "Let the daemon ask both instruments who they are");
    list.option(
        "--bundle", bundle_, kFileWord,
        "Also make this .tar.gz for a bug report: versions, findings, state, config, journal");
    list.options("--state", stated_, "KEY=VALUE",
                 "State this about the frame in the config file, such as travel_step_um=0.1");
    list.flag("--with-data", with_data_,
              "With all that was measured: database, runs' wire logs, numbers in the journal");
  }

  Outcome<ExitCode> run(Context& context) override {
    if (with_data_ && bundle_.empty()) {
      return Failure(kUsage, "--with-data is for --bundle FILE", "lcrig doctor --help");
    }
    auto statements = parse_statements(stated_);
    if (!statements) return statements.error();
    const Machine machine = real_machine();
    Findings findings;
    BundleParts parts;
    std::string daemons_file;  // empty: no daemon has named its database
    findings.push_back(look_at_daemon(context, parts, findings, daemons_file));
    look_at_service(machine, findings);
    findings.push_back(look_at_group("lcrig"));
    look_at_rig(context, machine, parts, findings);
    look_at_statements(context, parts.config_file, *statements, findings);
    look_at_data(context, machine, parts, findings, daemons_file);
    findings.push_back(look_at_clock(machine));
    findings.push_back(look_at_steal(machine));
    findings.push_back(look_at_lateness(context.clock));
    const auto all = findings_json(findings);
    show(context, all, [&](std::ostream& out) { print_findings(out, findings); });
    if (!bundle_.empty()) {
      parts.findings_json = all.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
      parts.with_data = with_data_;
      auto written = write_bundle(context.console, machine, bundle_, parts);
      if (!written) return written.error();
    }
    return exit_code_of(worst_of(findings));
  }

 private:
  // The instruments as the daemon sees them. Without a daemon nobody opens their ports.
  Finding look_at_daemon(Context& context, BundleParts& parts, Findings& findings,
                         std::string& its_file) {
    const std::string mend =
        "systemctl status lcrigd; " + doc_page("troubleshooting") + ", \"The daemon\"";
    const auto silent = [&](const Failure& why) {
      const bool advised = !why.no_daemon && !why.next.empty();
      return Finding("daemon", Health::warn, printable(why.what, kLongestWords),
                     advised ? why.next : mend);
    };
    const Duration patience = context.env.status_patience;
    auto client = ControlClient::connect_for_any_database(context, patience);
    if (!client) return silent(client.error());
    auto answer = ask_ ? client->call("instruments.ask", json::object(), std::chrono::minutes(1))
                       : client->call("status", json::object(), patience);
    if (!answer && ask_) {
      findings.emplace_back("instruments", Health::warn,
                            "not asked: " + printable(answer.error().what, kLongestWords));
      answer = client->call("status", json::object(), patience);
    }
    if (!answer) return silent(answer.error());
    const json bundled = with_data_ ? *answer : status_without_values(*answer);
    parts.status_json = bundled.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
    const auto status = parse_daemon_status(*answer);
    if (!status) return silent(Failure(status.error()));
    look_at_instruments(*status, findings);
    unstated_ = unstated_of(*status);
    its_file = status->database;
    if (ask_) {
      auto seen = client->call("lcr.show", json::object(), std::chrono::minutes(1));
      if (seen) corrections_ = read_corrections(*seen);
    }
    const auto words = fmt::format("lcrigd {} answers", printable(status->version, kLongestName));
    if (status->version == program_version()) return {"daemon", Health::ok, words};
    return {"daemon", Health::warn,
            fmt::format("{}, but this lcrig is {}", words, program_version()),
            "sudo systemctl restart lcrigd, after the run"};
  }

  static void look_at_rig(const Context& context, const Machine& machine, BundleParts& parts,
                          Findings& findings) {
    const auto file =
        context.global.config.empty() ? context.env.daemon_config.string() : context.global.config;
    const auto config = look_at_config(file, findings);
    if (!config) return;
    parts.config_file = config->file;
    parts.wire_log_directory = config->wire_log_directory;
    look_at_ports(machine, *config, findings);
    look_at_modules(machine, *config, findings);
  }

  void look_at_data(const Context& context, const Machine& machine, BundleParts& parts,
                    Findings& findings, const std::string& daemons_file) const {
    const auto path = context.db_path();
    if (path && *path == daemons_file) {
      if (auto replaced = look_whether_replaced(machine, *path)) findings.push_back(*replaced);
    }
    auto db = path ? open_read_only(*path) : fail(Errc::io, "{}", path.error().what);
    if (!db) {
      findings.emplace_back("database", Health::bad, printable(db.error().what, kLongestWords),
                            doc_page("troubleshooting") + ", \"The data\"");
      return;
    }
    parts.database = *path;
    look_at_database(*db, findings);
    findings.push_back(look_at_disk(*db, context.clock.unix_ns()));
    findings.push_back(look_at_plans(*db));
    look_at_meter_settings(*db, findings);
    look_at_corrections(*db, corrections_, context.clock.unix_ns(), findings);
    look_at_memory(machine, writer_of(*path), findings);
  }

  static std::vector<std::string> unstated_of(const DaemonStatus& status) {
    for (const InstrumentState& i : status.instruments) {
      if (i.which == Instrument::frame) return i.unstated;
    }
    return {};
  }

  // Asks once for what neither the frame nor the config states, and writes it.
  void look_at_statements(Context& context, const std::string& file, FrameStatements statements,
                          Findings& findings) const {
    if (file.empty()) return;  // a finding says why
    auto missing = without_stated(context, file, unstated_);
    const bool person = context.console.in_tty && context.console.err_tty && !context.global.json;
    if (statements.empty() && person) {
      statements = ask_for_statements(context.console, missing);
    }
    if (!statements.empty()) {
      findings.push_back(state_in_file(context, file, statements));
      missing = without_stated(context, file, std::move(missing));
    }
    if (missing.empty()) return;
    findings.emplace_back(
        "frame's facts", Health::warn,
        fmt::format("neither the frame nor {} states {}; without frame.force_loop no step may "
                    "control the force",
                    printable(file), fmt::join(missing, " and ")),
        "lcrig doctor at a terminal asks for it; or lcrig doctor --state KEY=VALUE; " +
            doc_page("config-file"));
  }

  std::string bundle_;
  std::vector<std::string> stated_, unstated_;
  std::optional<MeterCorrections> corrections_;  // what the meter answers now
  bool ask_ = false, with_data_ = false;
};

}  // namespace

const CommandFactory kDoctorCommand = make_command<DoctorCommand>;

}  // namespace lcrig::cli
