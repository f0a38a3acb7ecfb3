// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/cmd_rehearse.hpp"

#include <fmt/ostream.h>

#include <nlohmann/json.hpp>
#include <system_error>
#include <tuple>

#include "base/doc_page.hpp"
#include "base/json_or_null.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "daemon/rehearse.hpp"
#include "model/specimen_file.hpp"
#include "protocols/plan/check.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tools/lcrig/cmd_budget_scene.hpp"
#include "tools/lcrig/cmd_rehearse_batch.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/library_path.hpp"
#include "tools/lcrig/live_line.hpp"
#include "tools/lcrig/protocol_request.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

json to_json(const RehearseResult& r) {
  return json{{"run", r.run},
              {"simulated", true},
              {"exit_status", to_string(r.exit_status)},
              {"reason", r.reason},
              {"lcr_readings", r.lcr_readings},
              {"measure_readings", r.measure_readings},
              {"unproven_readings", r.unproven_readings},
              {"frame_samples", r.frame_samples},
              {"duration_s", r.duration_s},
              {"wall_s", r.wall_s},
              {"db", r.db_path},
              {"faults_injected", r.faults},
              {"remarks", r.remarks},
              {"anchor", r.anchor.empty() ? json() : json(r.anchor)},
              {"code", r.code ? json(to_string(*r.code)) : json(nullptr)},
              {"pressure", r.pressure ? lcrig::to_json(*r.pressure) : json(nullptr)},
              {"C0_pF", json_or_null(r.c0_pF)},
              {"peak_force_N", json_or_null(r.peak_force_N)},
              {"delta_C_fF_at_peak", json_or_null(r.delta_C_fF_at_peak)}};
}

void print_text(Console& console, const RehearseResult& r, const std::string& bench) {
  const auto pressure = r.pressure ? r.pressure->words() : std::string();
  if (!pressure.empty()) fmt::print(console.out, "{}\n", pressure);
  fmt::print(console.out, "run {}: {}{} ({})\n", r.run, to_string(r.exit_status),
             r.reason.empty() ? "" : " (" + printable(r.reason, kLongestWords) + ")",
             stand_in_word(bench));
  fmt::print(console.out, "{} LCR readings ({} of measure steps){}, {} frame samples\n",
             r.lcr_readings, r.measure_readings, unproven_words(r.unproven_readings),
             r.frame_samples);
  fmt::print(console.out, "{} of rig time in {:.2f} s\n", format_time(r.duration_s), r.wall_s);
  if (r.faults > 0) {
    fmt::print(console.out, "{} faults injected: events of kind `injected`\n", r.faults);
  }
  for (const std::string& remark : r.remarks) fmt::print(console.out, "{}\n", printable(remark));
  if (r.c0_pF) fmt::print(console.out, "C0 {} pF\n", format_fixed(*r.c0_pF, 4));
  if (r.peak_force_N) {
    fmt::print(console.out, "peak force {} N\n", format_fixed(*r.peak_force_N, 4));
  }
  if (r.delta_C_fF_at_peak) {
    fmt::print(console.out, "delta C there {} fF\n", format_fixed(*r.delta_C_fF_at_peak, 3));
  }
  if (!r.anchor.empty()) fmt::print(console.out, "anchor {}\n", r.anchor);
  console.next(
      next_command(at_database(r.db_path), {"export", std::to_string(r.run), "-o", "results"}));
}

class RehearseCommand final : public Command {
 public:
  RehearseCommand()
      : Command("rehearse",
                "The same run on the simulated bench, in virtual time, without a daemon",
                "lcrig rehearse static-frame --specimen paper-1") {}
  void declare(ArgumentList& list) override {
    list.positional(kProtocolWord, protocol_, "Name or file; not with --batch", false);
    list.options("-p,--parameter", parameters_, kParameterWord, "Change a parameter");
    list.option("-s,--specimen", specimen_, kSpecimenWord,
                "Name or file of what is on the bench (not needed with replay:DIR)");
    list.option("--bench", bench_, kBenchWord,
                "Name or file of a bench, or replay:DIR (default: paper)");
    list.seed("--seed", seed_, "Noise of the simulated instruments, and the order of a batch");
    batch_.declare(list);
    list.number("--hand-time", hand_s_, "SECONDS",
                "What a person takes at each gate of a batch (default: 120)");
    const std::string realistic =
        "Let the bench err as real ones do (" + doc_page("simulator") + ")";
    list.flag("--realistic", realistic_, realistic.c_str());
    list.option("--operator", operator_, kOperatorWord, "Who runs it (default: you)");
    list.option("--note", note_, "TEXT", "Stored with the run");
    list.option("--faults", faults_, kFileWord, "Let things go wrong as this script says");
    list.option("--answers", answers_, kFileWord, "Answers to the questions of the protocol");
  }

  Outcome<ExitCode> run(Context& context) override {
    if (auto fits = check_words(); !fits) return fits.error();
    if (batch_.given()) return rehearse_day(context);
    auto wanted = request(context);
    if (!wanted) return wanted.error();
    LiveLine line(context.console, context.clock);
    wanted->progress = [&line](const RunStatus& status) { line.show(status); };
    auto result = context.daemon.rehearse(*wanted);
    line.finish();
    if (!result) {
      return refused(context, result.error(), *wanted);
    }
    if (context.global.json) {
      print_json(context.console.out, to_json(*result));
    } else {
      print_text(context.console, *result, bench_);
    }
    return exit_code_of_run(result->exit_status, result->code);
  }

 private:
  Outcome<bool> check_words() const {
    const auto usage = [](const std::string& what) {
      return Failure(kUsage, "lcrig rehearse: " + what, "lcrig rehearse --help");
    };
    if (!batch_.given()) {
      if (const auto stray = batch_.stray(); !stray.empty()) {
        return usage(stray + " is for --batch FILE");
      }
      if (protocol_.empty()) return usage("PROTOCOL is missing");
      return true;
    }
    const std::pair<const char*, bool> others[] = {
        {"PROTOCOL", !protocol_.empty()}, {"--specimen", !specimen_.empty()},
        {"-p", !parameters_.empty()},     {"--note", !note_.empty()},
        {"--faults", !faults_.empty()},   {"--answers", !answers_.empty()}};
    for (const auto& [word, given] : others) {
      if (given) return usage(fmt::format("{} and --batch exclude each other", word));
    }
    if (replay_directory(bench_)) return usage("--batch needs a simulated bench");
    if (!(hand_s_ >= 0 && hand_s_ <= 86400)) return usage("--hand-time: expected 0 to 86400");
    return true;
  }

  Outcome<ExitCode> rehearse_day(Context& context) const {
    auto db = database(context);
    if (!db) return db.error();
    auto batch = batch_.read(context, *db, seed_);
    if (!batch) return batch.error();
    RehearseBatchRequest request;
    request.db_path = std::move(*db);
    request.bench = bench_;
    auto bench = LibraryPath(context.env).find(LibraryKind::bench, bench_);
    if (!bench) return bench.error();
    if (*bench) request.bench_text = std::move((*bench)->text);
    request.seed = seed_;
    if (realistic_) request.errors = ErrorScope::everything;
    request.hand_s = hand_s_;
    request.begin_unix_ns = context.clock.unix_ns();
    request.batch.operator_name = operator_.empty() ? login_name() : operator_;
    return rehearse_table(context, *batch, std::move(request), batch_);
  }

  Outcome<RehearseRequest> request(const Context& context) const {
    RehearseRequest out;
    const LibraryPath library(context.env);
    auto wanted = find_protocol(library, protocol_, parameters_);
    if (!wanted) return wanted.error();
    out.parameters = std::move(wanted->parameters);
    out.protocol_name = wanted->file.path.filename().string();
    out.protocol_text = std::move(wanted->file.text);
    auto db = database(context);
    if (!db) return db.error();
    out.db_path = std::move(*db);
    out.bench = bench_;
    const bool replay = replay_directory(bench_).has_value();
    if (specimen_.empty() && !replay) {
      return Failure(kUsage, "lcrig rehearse: --specimen is missing",
                     next_command(context.global, {"specimen", "list"},
                                  "paper-1, paper-2, paper-3 ship with it"));
    }
    if (!specimen_.empty()) {
      auto specimen = find_specimen_text(context, out.db_path, specimen_);
      if (!specimen) return specimen.error();
      out.specimen_name = specimen->name;
      out.specimen_text = std::move(specimen->text);
    }
    if (!replay) {
      auto bench = library.find(LibraryKind::bench, bench_);
      if (!bench) return bench.error();
      if (*bench) out.bench_text = std::move((*bench)->text);
    }
    out.faults_name = faults_;
    out.answers_name = answers_;
    for (const auto& [option, file, text] :
         {std::tuple("--faults", &faults_, &out.faults_text),
          std::tuple("--answers", &answers_, &out.answers_text)}) {
      if (file->empty()) continue;
      auto read = keep(read_text_file(*file), *text);
      if (!read) return Failure(read.error(), fmt::format("give another {}", option));
    }
    out.seed = seed_;
    if (realistic_) out.errors = ErrorScope::everything;
    out.operator_name = operator_.empty() ? login_name() : operator_;
    out.note = note_;
    return out;
  }

  Outcome<std::string> database(const Context& context) const {
    if (const auto& db = context.global.db; !db.empty()) return usable(db);
    const auto path = context.env.rehearsal_db();
    std::error_code ec;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ec);
    if (ec) {
      return Failure(kFailed,
                     fmt::format("cannot create {}: {}", path.parent_path().string(), ec.message()),
                     "give --db FILE, in a folder that you may write to");
    }
    return path.string();
  }

  static Outcome<std::string> usable(const std::string& db) {
    const auto folder = std::filesystem::path(db).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !std::filesystem::is_directory(folder, ignored)) {
      return Failure(kFailed,
                     fmt::format("there is no folder {}, for --db {}", folder.string(), db),
                     fmt::format("correct --db, or: mkdir -p {}", shell_quoted(folder.string())));
    }
    return db;
  }

  Failure refused(const Context& context, const Error& error, const RehearseRequest& wanted) const {
    const std::string& db = wanted.db_path;
    // An empty file may become a database.
    std::error_code ignored;
    const bool file = std::filesystem::file_size(db, ignored) > 0 && !ignored;
    if (const auto folder = replay_directory(bench_); folder && !std::filesystem::exists(*folder)) {
      return Failure(
          error, "give the folder of a recording, with lcr.csv and frame.csv: --bench replay:DIR");
    }
    const bool two_names = file && std::filesystem::hard_link_count(db, ignored) > 1;
    const bool usable = require_safe_to_create(db) && !two_names && (!file || open_read_only(db));
    if (error.code != Errc::invalid_request || !usable) {
      return Failure(error, "give another --db");
    }
    const auto again = find_protocol(LibraryPath(context.env), protocol_, parameters_);
    if (!again) return again.error();
    if (auto bound = bind_protocol(context, *again); !bound) return bound.error();
    if (auto bench = broken_bench(context, wanted)) return *bench;
    Failure failure = plan_refused(context, protocol_, error);
    if (!faults_.empty()) {
      failure.next = "correct what the message names; " + doc_page("faults") + " has scripts";
    }
    return failure;
  }

  static std::optional<Failure> broken_bench(const Context& context,
                                             const RehearseRequest& wanted) {
    if (context.daemon.bench_rig == nullptr) return std::nullopt;
    BenchRequest bench;
    bench.bench = wanted.bench;
    bench.bench_text = wanted.bench_text;
    if (auto rig = context.daemon.bench_rig(bench); !rig) {
      return bench_refused(context, rig.error(), bench);
    }
    if (!parse_specimen(wanted.specimen_text, wanted.specimen_name)) return std::nullopt;
    bench.specimen_name = wanted.specimen_name;
    bench.specimen_text = wanted.specimen_text;
    const auto rig = context.daemon.bench_rig(bench);
    if (rig) return std::nullopt;
    return bench_refused(context, rig.error(), bench);
  }

  std::string protocol_, specimen_, bench_ = kUsualBench, operator_, note_, faults_, answers_;
  std::vector<std::string> parameters_;
  std::optional<std::uint64_t> seed_;
  bool realistic_ = false;
  BatchOptions batch_;
  double hand_s_ = 120;
};

}  // namespace

const CommandFactory kRehearseCommand = make_command<RehearseCommand>;

}  // namespace lcrig::cli
