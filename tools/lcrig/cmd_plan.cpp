// SPDX-License-Identifier: Apache-2.0
// protocol plan: what a protocol will do, without instruments.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "budget/planned_run.hpp"
#include "daemon/rehearse.hpp"
#include "protocols/expand.hpp"
#include "protocols/plan/plan.hpp"
#include "storage/runs.hpp"
#include "tools/lcrig/cmd_budget_scene.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/library_path.hpp"
#include "tools/lcrig/plan_text.hpp"
#include "tools/lcrig/protocol_request.hpp"

namespace lcrig::cli {

namespace {

class PlanCommand final : public Command {
 public:
  PlanCommand()
      : Command("protocol plan", "Steps, time, readings, forces, without moving",
                "lcrig protocol plan dynamic-cycles -p cycles=20") {}
  void declare(ArgumentList& list) override {
    list.positional(kProtocolWord, protocol_, "Name or file");
    list.options("-p,--parameter", parameters_, kParameterWord, "Change a parameter");
    list.option("-s,--specimen", specimen_, kSpecimenWord,
                "For better estimates: what will be pressed");
    list.option("--bench", bench_, kBenchWord, "Instruments and fixture (default: paper)");
  }

  Outcome<ExitCode> run(Context& context) override {
    const LibraryPath library(context.env);
    const auto wanted = find_protocol(library, protocol_, parameters_);
    if (!wanted) return wanted.error();
    auto bound = bind_protocol(context, *wanted);
    if (!bound) return bound.error();
    const auto& [protocol, environment] = *bound;
    auto request = bench_request(context, library);
    if (!request) return request.error();
    request->weights = places_weights(protocol.steps);
    auto rig = context.daemon.bench_rig(*request);
    if (!rig) return bench_refused(context, rig.error(), *request);
    auto plan = make_plan(protocol, environment, *rig);
    if (!plan) return plan_refused(context, protocol_, plan.error());
    if (!shows_drift(protocol, environment, *rig, *plan)) {
      plan->assumptions.emplace_back(
          "the unloaded capacitance does not drift: the protocol has no two rests without load, of "
          "six readings each, that would tell (a hold with the probe off, before and after the "
          "load)");
    }
    const nlohmann::json all = to_json(*plan);
    return show(context, all, [&](std::ostream& out) {
      print_plan(out, all);
      context.console.next(rehearsal(context));
    });
  }

 private:
  std::string rehearsal(const Context& context) const {
    Words words{"rehearse", protocol_};
    add_options(words, "-p", parameters_);
    add_option(words, "--specimen",
               specimen_.empty() && !replay_directory(bench_) ? "paper-1" : specimen_);
    if (bench_ != kUsualBench) add_option(words, "--bench", bench_);
    return next_command(context.global, words);
  }

  Outcome<BenchRequest> bench_request(const Context& context, const LibraryPath& library) const {
    BenchRequest out;
    out.bench = bench_;
    if (!replay_directory(bench_)) {
      auto bench = library.find(LibraryKind::bench, bench_);
      if (!bench) return bench.error();
      if (*bench) out.bench_text = std::move((*bench)->text);
    }
    if (specimen_.empty()) return out;
    auto db = context.db_path();
    if (!db) return db.error();
    auto specimen = find_specimen_text(context, *db, specimen_);
    if (!specimen) return specimen.error();
    out.specimen_name = specimen->name;
    out.specimen_text = std::move(specimen->text);
    return out;
  }

  std::string protocol_, specimen_, bench_ = kUsualBench;
  std::vector<std::string> parameters_;
};

}  // namespace

const CommandFactory kProtocolPlanCommand = make_command<PlanCommand>;

}  // namespace lcrig::cli
