// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "analysis/export.hpp"
#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class ExportCommand final : public Command {
 public:
  ExportCommand()
      : Command("export", "Write a run as CSV files and a data package",
                "lcrig export last -o results") {}
  void declare(ArgumentList& list) override {
    list.positional(kRunWord, run_, "A number, the beginning of its uuid, or `last` (default)",
                    false);
    list.option("-o,--output", output_, {"DIR", Proposes::folder},
                "Folder, or - for standard output (default: run-RUN)");
    list.one_of("--layout", layout_, {"readings", "frame", "levels", "events", "aligned"},
                "One table, with -o - (default: readings)");
    list.option("--license", license_, "NAME",
                "Of the data, for datapackage.json: CC-BY-4.0, or an address (default: "
                "$LCRIG_LICENSE, else none)");
    list.flag("--force", force_, "Replace files that are no export of this run");
  }

  Outcome<ExitCode> run(Context& context) override {
    const bool standard_output = output_ == "-";
    if (!layout_.empty() && !standard_output) {
      return Failure(
          kUsage, "--layout is for -o - (a folder gets every table)",
          next_command(context.global, {"export", run_, "-o", "-", "--layout", layout_}));
    }
    auto run = open_run(context, run_);
    if (!run) return run.error();
    return standard_output ? to_output(context, run->db, run->number)
                           : to_folder(context, run->db, run->number);
  }

 private:
  Outcome<ExitCode> to_output(Context& context, const Database& db, std::int64_t run) const {
    const auto layout = parse_word<Layout>(layout_.empty() ? "readings" : layout_);
    if (!layout) return Failure(kUsage, "unknown --layout", "lcrig export --help");
    context.console.out.flush();
    auto checked = verify_aside(db, run);
    auto done = export_layout(db, run, *layout, STDOUT_FILENO, "standard output");
    if (!done) return Failure(done.error(), next_after(done.error()));
    const auto chain = checked.get();
    if (!chain) return Failure(chain.error(), next_after(chain.error()));
    remark(*chain, context, run);
    return kOk;
  }

  Outcome<ExitCode> to_folder(Context& context, const Database& db, std::int64_t run) const {
    ExportOptions options;
    options.directory = output_.empty() ? fmt::format("run-{}", run) : output_;
    options.force = force_;
    options.license = license_.empty() ? context.env.get("LCRIG_LICENSE").value_or("") : license_;
    auto done = export_run(db, run, options);
    if (!done) {
      const bool fits = options.license.empty() || check_license(options.license);
      const auto next = elsewhere(context, run, fits ? license_ : "CC-BY-4.0");
      return Failure(done.error(), next_after(done.error(), next));
    }
    remark(done->chain, context, run);
    const json all{{"run", run},
                   {"goes_on", done->chain.goes_on},
                   {"files", done->files},
                   {"intact", done->chain.intact},
                   {"finding", done->chain.finding}};
    return show(context, all, [&](std::ostream& out) {
      for (const auto& file : done->files) fmt::print(out, "{}\n", printable(file));
    });
  }

  std::string elsewhere(const Context& context, std::int64_t run,
                        const std::string& license) const {
    Words words{"export", std::to_string(run), "-o",
                license == license_ ? "ANOTHER-FOLDER" : output_};
    if (license != license_ && output_.empty()) words.resize(2);
    add_option(words, "--license", license);
    return next_command(context.global, words);
  }

  static void remark(const ChainReport& chain, const Context& context, std::int64_t run) {
    note_if_changed(context, chain, run);
    if (chain.goes_on) {
      context.console.note(
          fmt::format("run {} goes on: this is what was recorded until now; export it again when "
                      "it has ended",
                      run));
    }
  }

  std::string run_ = "last", output_, layout_, license_;
  bool force_ = false;
};

}  // namespace

const CommandFactory kExportCommand = make_command<ExportCommand>;

}  // namespace lcrig::cli
