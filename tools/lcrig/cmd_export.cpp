// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "analysis/export.hpp"
#include "base/text.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class ExportCommand final : public Command {
 public:
  const char* name() const override { return "export"; }
  const char* summary() const override { return "Write a run as CSV files and a data package"; }
  const char* example() const override { return "lcrig export last -o results"; }
  void declare(ArgumentList& list) override {
    list.positional("RUN", run_, "A number, or `last`");
    list.option("-o,--output", output_, "DIR",
                "Folder, or - for standard output (default: run-RUN)");
    list.one_of("--layout", layout_, {"readings", "frame", "levels", "events", "aligned"},
                "One table (needed with -o -)");
    list.flag("--force", force_, "Replace files that are no export of this run");
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Outcome<ExitCode> to_output(Context& context, const Database& db, std::int64_t run) const;
  Outcome<ExitCode> to_folder(Context& context, const Database& db, std::int64_t run) const;
  std::string run_, output_, layout_;
  bool force_ = false;
};

Outcome<ExitCode> ExportCommand::to_output(Context& context, const Database& db,
                                           std::int64_t run) const {
  const auto layout = parse_layout(layout_.empty() ? "readings" : layout_);
  if (!layout) return tl::unexpected(Failure(kUsage, "unknown --layout", "lcrig export --help"));
  context.console.out.flush();
  auto done = export_layout(db, run, *layout, STDOUT_FILENO, "standard output");
  if (!done) return tl::unexpected(Failure(done.error()));
  return kOk;
}

Outcome<ExitCode> ExportCommand::to_folder(Context& context, const Database& db,
                                           std::int64_t run) const {
  ExportOptions options;
  options.directory = output_.empty() ? fmt::format("run-{}", run) : output_;
  options.force = force_;
  auto files = export_run(db, run, options);
  if (!files) {
    return tl::unexpected(Failure(files.error(), "lcrig export RUN -o ANOTHER-FOLDER"));
  }
  if (context.global.json) {
    json out = json::object();
    out["run"] = run;
    out["files"] = *files;
    print_json(context.console.out, out);
    return kOk;
  }
  for (const auto& file : *files) fmt::print(context.console.out, "{}\n", printable(file));
  return kOk;
}

Outcome<ExitCode> ExportCommand::run(Context& context) {
  const bool standard_output = output_ == "-";
  if (!layout_.empty() && !standard_output) {
    return tl::unexpected(Failure(kUsage, "--layout is for -o - (a folder gets every table)",
                                  "lcrig export " + run_ + " -o - --layout " + layout_));
  }
  auto db = open_runs(context);
  if (!db) return tl::unexpected(db.error());
  auto number = named_run(*db, run_);
  if (!number) return tl::unexpected(number.error());
  if (standard_output) return to_output(context, *db, *number);
  return to_folder(context, *db, *number);
}

}  // namespace

std::unique_ptr<Command> make_export_command() {
  return std::make_unique<ExportCommand>();
}

}  // namespace lcrig::cli
