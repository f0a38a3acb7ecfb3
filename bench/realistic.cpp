// SPDX-License-Identifier: Apache-2.0
#include "bench/realistic.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/comparison.hpp"
#include "base/strict_json.hpp"
#include "bench/drawn_truth.hpp"
#include "daemon/rehearse.hpp"
#include "daemon/rig/bench.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"

namespace lcrig::worlds {

namespace {

struct BenchRun {
  RunData data;
  RunAnalysis analysis;
  nlohmann::json drawn;
};

// One run: its noise is drawn from `seed`, its rig from `rig_seed`.
struct Occasion {
  std::uint64_t seed = 0, rig_seed = 0;
  ErrorScope scope = ErrorScope::everything;
};

BenchRun rehearse_with(const Rehearsed& what, const Occasion& occasion, const std::string& folder) {
  RehearseRequest request;
  request.protocol_name = what.name;
  request.protocol_text = what.text;
  request.parameters = what.parameters;
  request.specimen_name = "paper-1";
  request.specimen_text = shipped_specimens().front().text;
  request.seed = occasion.seed;
  request.rig_seed = occasion.rig_seed;
  request.errors = occasion.scope;
  request.db_path = folder + "/run.db";
  for (const char* tail : {"", "-wal", "-shm"}) std::filesystem::remove(request.db_path + tail);
  const auto result = rehearse(request);
  if (!result || result->exit_status != ExitStatus::success) {
    throw std::runtime_error(
        fmt::format("seed {}: {}", occasion.seed, result ? result->reason : result.error().what));
  }
  const auto db = open_read_only(request.db_path).value();
  RunData data = load_run_data(db, result->run).value();
  RunAnalysis analysis = analyse(data).value();
  return {std::move(data), std::move(analysis),
          nlohmann::json::parse(*get_run(db, result->run)->model_error_json)["drawn"]};
}

// The specimen on the bench, for its curve.
std::unique_ptr<BenchWorld> make_bench_world() {
  const Specimen specimen = parse_specimen(shipped_specimens().front().text, "paper-1").value();
  const Bench bench = find_bench("paper").value();
  return BenchWorld::make(specimen, bench.fixture.probe_diameter_m, bench.error_tolerance,
                          Force::from_si(3), bench.plant)
      .value();
}

// Results by the name of the metric; for slopes also by their range.
std::map<std::string, Judged> results_of(const RunAnalysis& a) {
  std::map<std::string, Judged> out;
  const auto add = [&out](const Metric& m, const std::string& name,
                          std::optional<double> expanded) {
    if (m && m.estimate->interval) out[name] = {name, *m.estimate, expanded, 0, 0};
  };
  for (const Metric* m : a.metrics()) {
    if (m->name != "sensitivity_fF_per_kPa") add(*m, m->name, std::nullopt);
  }
  for (const RangeResult& r : a.ranges) {
    add(r.sensitivity, fmt::format("slope {:g}-{:g} kPa", r.range.from_kPa, r.range.to_kPa),
        r.uncertainty.expanded);
  }
  for (const Uncertainty& u : a.uncertainties) {
    for (const auto& [quantity, metric] : {std::pair("C0", "C0_pF"),
                                           {"dynamic range", "dynamic_range_percent"},
                                           {"force sensitivity", "force_sensitivity_fF_per_N"},
                                           {"delta C at", "delta_C_at_top_fF"},
                                           {"hysteresis", "hysteresis_percent"}}) {
      const auto at = out.find(metric);
      if (u.quantity.starts_with(quantity) && at != out.end()) {
        at->second.expanded = u.expanded;
      }
    }
  }
  return out;
}

// The protocol at 100 kHz, where noise does not hide the errors of a bench.
std::string text_at_100_kHz(const std::string& name) {
  std::string text = read_text_file("protocols/library/" + name + ".json").value();
  const std::string slow = "\"frequency_Hz\": 1000,";
  return text.replace(text.find(slow), slow.size(), "\"frequency_Hz\": 100000,");
}

// Adds the increase from one run to another of the same specimen on the same rig; its truth is 0.
void add_comparisons(const RunAnalysis& from, const RunAnalysis& to, std::vector<Judged>& out) {
  const RunAnalysis runs[] = {from, to};
  for (const Comparison& c : compare(runs)) {
    if (!c.interval_percent) continue;
    Judged judged;
    judged.result = "increase, " + c.quantity;
    judged.estimate = Estimate(*c.increase_percent);
    judged.estimate.interval = c.interval_percent;
    out.push_back(std::move(judged));
  }
}

}  // namespace

Rehearsed rehearsed_levels(int repeats, int readings) {
  return {"static-frame",
          text_at_100_kHz("static-frame"),
          {{"repeats", std::to_string(repeats)},
           {"readings", std::to_string(readings)},
           {"within_s", std::to_string(0.15 * readings)},
           {"levels", "10"},
           {"rate_N_s", "0.5"}}};
}

Rehearsed rehearsed_cycles(int cycles) {
  return {"dynamic-cycles",
          text_at_100_kHz("dynamic-cycles"),
          {{"cycles", std::to_string(cycles)}, {"gap_mm", "0.1"}}};
}

std::vector<Judged> judge_on_bench(const Rehearsed& what, std::uint64_t seed,
                                   const std::string& folder) {
  constexpr std::uint64_t kAnotherDay = 0x5eed'0000'0000ULL;
  static const auto world = make_bench_world();
  const BenchRun real = rehearse_with(what, {seed, seed}, folder);
  const BenchRun later = rehearse_with(what, {seed ^ kAnotherDay, seed}, folder);
  const auto of_rig =
      results_of(rehearse_with(what, {seed, seed, ErrorScope::lasting}, folder).analysis);
  const auto own =
      results_of(rehearse_with(what, {seed, seed, ErrorScope::specimen}, folder).analysis);
  const auto drawn = drawn_truths(real.data, real.analysis, *world, real.drawn);
  std::vector<Judged> out;
  for (auto& [name, judged] : results_of(real.analysis)) {
    if (const auto known = drawn.find(name); known != drawn.end()) {
      judged.of_rig = known->second.of_rig;
      judged.own = known->second.own;
    } else if (name == "limit_of_detection_kPa") {
      const double noise_fF = drawn.at("noise_fF").of_rig;
      judged.of_rig = 3 * noise_fF / of_rig.at("slope 0-30 kPa").estimate.value;
      judged.own = 3 * noise_fF / own.at("slope 0-30 kPa").estimate.value;
    } else if (of_rig.contains(name) && own.contains(name)) {
      judged.of_rig = of_rig.at(name).estimate.value;
      judged.own = own.at(name).estimate.value;
    } else {
      continue;
    }
    out.push_back(judged);
  }
  add_comparisons(real.analysis, later.analysis, out);
  return out;
}

}  // namespace lcrig::worlds
