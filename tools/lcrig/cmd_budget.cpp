// SPDX-License-Identifier: Apache-2.0
// budget: what a protocol will cost and how well it will measure, for each setting of the meter.
#include <fmt/ostream.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/measured_noise.hpp"
#include "protocols/rig/limits.hpp"
#include "tools/lcrig/budget_text.hpp"
#include "tools/lcrig/cmd_budget_scene.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/library_path.hpp"
#include "tools/lcrig/model_options.hpp"
#include "tools/lcrig/output_file.hpp"
#include "tools/lcrig/protocol_request.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

namespace {

constexpr double kUsual_Hz[] = {1e3, 1e4, 1e5};  // tried when there is a target

// With a target, other test frequencies are tried, too: they decide how quickly it is reached.
std::vector<double> usual_frequencies(const Protocol& protocol, const Rig& rig, bool with_target) {
  std::vector<double> out{protocol.sample.lcr.frequency.si()};
  for (const double Hz : kUsual_Hz) {
    const bool can = rig.lcr.frequency_min.si() <= Hz && Hz <= rig.lcr.frequency_max.si();
    if (with_target && can && Hz != out.front()) out.push_back(Hz);
  }
  return out;
}

class BudgetCommand final : public Command {
 public:
  BudgetCommand()
      : Command(
            "budget", "What a protocol will cost and how well it will measure, before the run",
            "lcrig budget static-frame --specimen paper-1 --frequency-Hz 1000,100000 --target 1%") {
  }
  void declare(ArgumentList& list) override {
    list.positional(kProtocolWord, protocol_, "Name or file");
    list.option("-s,--specimen", specimen_, kSpecimenWord, "What will be pressed: a name or a file",
                true);
    list.options("-p,--parameter", parameters_, kParameterWord, "Change a parameter");
    list.option("--frequency-Hz", frequencies_, "F,...",
                "Test frequencies (default: the file's; with a target also 1, 10 and 100 kHz)");
    list.option("--target", target_, "PERCENT",
                "Find the settings whose intervals are this narrow, e.g. 1%");
    list.option("--bench", bench_, kBenchWord, "Instruments and fixture (default: paper)");
    list.option("--noise-from", noise_from_, kRunWord,
                "Noise as this run showed it: a number or last");
    list.option("--svg", svg_, kFileWord, "Picture of error against time");
  }

  Outcome<ExitCode> run(Context& context) override {
    if (auto fits = require_replaceable(svg_, kPictureMark); !fits) return fits.error();
    auto wanted = target();
    if (!wanted) return wanted.error();
    auto what = scene(context);
    if (!what) return what.error();
    auto list = frequencies(what->protocol, what->rig);
    if (!list) return list.error();
    BudgetQuestion question{
        what->protocol, what->environment, what->rig, what->curve, {}, {}, {}, {}};
    question.apertures = {Aperture::fast, Aperture::medium, Aperture::slow};
    question.frequencies_Hz = std::move(*list);
    question.target = *wanted;
    const Budget budget = reckon_budget(question);
    const auto possible = [](const BudgetSetting& s) { return s.planned.possible(); };
    if (std::ranges::none_of(budget.settings, possible)) {
      return refused(context,
                     Error(Errc::invalid_request, budget.settings.front().planned.refused));
    }
    if (!svg_.empty()) {
      const std::string title = fmt::format("Budget of {} on {}", what->protocol.name, specimen_);
      auto written = write_file(svg_, kPictureMark, to_svg(budget, title));
      if (!written) return written.error();
    }
    auto all = cli::to_json(budget);
    all["protocol"] = what->protocol.name;
    all["specimen"] = specimen_;
    all["bench"] = bench_;
    const std::string command =
        budget.cheapest ? command_for(context.global, *budget.cheapest) : "";
    if (budget.cheapest) all["command"] = command;
    return show(context, all, [&](std::ostream& out) {
      out << to_table(budget);
      if (!command.empty()) fmt::print(out, "  {}\n", command);
    });
  }

 private:
  // The protocol, rig and specimen for which the budget is computed.
  struct Scene {
    Protocol protocol;
    Environment environment;
    Rig rig;
    SpecimenCurve curve;
  };

  Outcome<Scene> scene(const Context& context) const {
    const LibraryPath library(context.env);
    const auto wanted = find_protocol(library, protocol_, parameters_);
    if (!wanted) return wanted.error();
    auto bound = bind_protocol(context, *wanted);
    if (!bound) return bound.error();
    auto db = context.db_path();
    if (!db) return db.error();
    auto text = find_specimen_text(context, *db, specimen_);
    if (!text) return text.error();
    auto bench = budget_rig(context, bench_, *text, bound->protocol);
    if (!bench) return bench.error();
    if (!noise_from_.empty() && bench->noise) {
      auto noise = noise_of_run(context, *bench->noise);
      if (!noise) return noise.error();
      bench->noise = std::move(*noise);
    }
    const auto limits = bind_limits(bound->protocol, bound->environment, bench->frame);
    if (!limits) return refused(context, limits.error());
    auto curve = budget_curve(*text, bound->protocol, bound->environment, *bench);
    if (!curve) return Failure(curve.error(), "lcrig model curve --help");
    return Scene{std::move(bound->protocol), std::move(bound->environment), std::move(*bench),
                 std::move(*curve)};
  }

  // Noise measured in a run. The run gives the noise of its own setting. For other apertures it is
  // scaled by the ratios of the bench.
  Outcome<InstrumentNoise> noise_of_run(const Context& context,
                                        const InstrumentNoise& bench) const {
    auto db = open_runs(context);
    if (!db) return db.error();
    auto run = named_run(context, *db, noise_from_);
    if (!run) return run.error();
    auto checked = verify_aside(*db, *run);
    const auto seen = measured_noise(*db, *run);
    if (!seen) {
      const auto look = next_command(context.global, {"analyze", std::to_string(*run)});
      return Failure(seen.error(), next_after(seen.error(), look));
    }
    const auto chain = checked.get();
    if (!chain) return Failure(chain.error(), next_after(chain.error()));
    note_if_changed(context, *chain, *run);
    const MeterSetting& m = seen->meter;
    const auto aperture = static_cast<std::size_t>(m.aperture);
    const double once =
        seen->reading_F * (m.frequency_Hz / 1000) * m.level_V * std::sqrt(m.average);
    InstrumentNoise out = bench;
    for (double& F : out.capacitance_F) F *= once / bench.capacitance_F[aperture];
    out.guessed = {true, true, true};
    out.guessed[aperture] = false;
    if (seen->force_N) out.force_N = *seen->force_N;
    out.basis = fmt::format("run {}: {:.3g} fF of a reading ({}, {:g} Hz)", *run,
                            seen->reading_F * 1e15, to_string(m.aperture), m.frequency_Hz);
    return out;
  }

  // The command for exactly this point: the -p of the command line, then those that the point
  // changes.
  std::string command_for(const GlobalOptions& global, const BudgetPoint& point) const {
    std::map<std::string, std::string> changes;
    for (const std::string& p : parameters_) {
      if (auto typed = split_assignment(p)) changes.insert(std::move(*typed));
    }
    for (const auto& [what, value] : point.parameters) changes[what] = fmt::format("{}", value);
    changes["frequency_Hz"] = fmt::format("{}", point.frequency_Hz);
    changes["aperture"] = to_string(point.aperture);
    Words words{"run", protocol_};
    add_option(words, "--specimen", specimen_);
    for (const auto& [what, value] : changes) {
      add_option(words, "-p", fmt::format("{}={}", what, value));
    }
    return next_command(global, words,
                        point.follows ? "" : fmt::format("and in the file: {}", point.note));
  }

  Outcome<std::optional<double>> target() const {
    if (target_.empty()) return std::optional<double>();
    std::string number = target_;
    if (number.ends_with('%')) number.pop_back();
    auto percent = parse_number("--target", number);
    if (!percent) return percent.error();
    if (!(*percent > 0)) {
      return Failure(kUsage, "--target: expected percent above 0",
                     "give how wide an interval may be, such as 1%");
    }
    constexpr double kSurelyPercent = 0.5;
    if (*percent < kSurelyPercent && !target_.ends_with('%')) {
      const std::string whole = fmt::format("--target {:.6g}%", *percent * 100);
      return Failure(
          kUsage, fmt::format("--target {}: {:.6g} % or {} %?", target_, *percent * 100, target_),
          fmt::format("say which: {} or --target {}%", whole, target_));
    }
    return std::optional(*percent / 100);
  }

  Outcome<std::vector<double>> frequencies(const Protocol& protocol, const Rig& rig) const {
    if (frequencies_.empty()) return usual_frequencies(protocol, rig, !target_.empty());
    std::vector<double> out;
    std::string_view rest = frequencies_;
    while (true) {
      const auto end = std::min(rest.find(','), rest.size());
      auto Hz = parse_number("--frequency-Hz", std::string(rest.substr(0, end)));
      if (!Hz) return Hz.error();
      if (!(*Hz > 0)) {
        return Failure(kUsage, "--frequency-Hz: expected frequencies above 0",
                       "give them in Hz, such as 1000,100000");
      }
      out.push_back(*Hz);
      if (end == rest.size()) return out;
      rest.remove_prefix(end + 1);
    }
  }

  Failure refused(const Context& context, const Error& error) const {
    return plan_refused(context, protocol_, error);
  }

  std::string protocol_, specimen_, frequencies_, target_, bench_ = kUsualBench, svg_, noise_from_;
  std::vector<std::string> parameters_;
};

}  // namespace

const CommandFactory kBudgetCommand = make_command<BudgetCommand>;

}  // namespace lcrig::cli
