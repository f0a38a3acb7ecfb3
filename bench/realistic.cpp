// SPDX-License-Identifier: Apache-2.0
#include "bench/realistic.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/strict_json.hpp"
#include "daemon/rehearse.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"

namespace lcrig::worlds {

namespace {

struct BenchRun {
  RunAnalysis analysis;
  nlohmann::json drawn;
  double middle_of_baseline_s = 0;
};

BenchRun rehearse_with(const Rehearsed& what, std::uint64_t seed, ErrorScope scope,
                       const std::string& folder) {
  RehearseRequest request;
  request.protocol_name = what.name;
  request.protocol_text = what.text;
  request.parameters = what.parameters;
  request.specimen_name = "paper-1";
  request.specimen_text = shipped_specimens().front().text;
  request.seed = seed;
  request.errors = scope;
  request.db_path = folder + "/run.db";
  for (const char* tail : {"", "-wal", "-shm"}) std::filesystem::remove(request.db_path + tail);
  const auto result = rehearse(request);
  if (!result || result->exit_status != ExitStatus::success) {
    throw std::runtime_error(
        fmt::format("seed {}: {}", seed, result ? result->reason : result.error().what));
  }
  const auto db = open_read_only(request.db_path).value();
  const RunData data = load_run_data(db, result->run).value();
  BenchRun out{analyse(data).value(), {}, data.contact_s.value_or(0) / 2};
  out.drawn = nlohmann::json::parse(*get_run(db, result->run)->model_error_json)["drawn"];
  return out;
}

// Results by the name of the metric, and for slopes the range.
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
                                           {"hysteresis", "hysteresis_percent"}}) {
      if (const auto at = out.find(metric); u.quantity == quantity && at != out.end()) {
        at->second.expanded = u.expanded;
      }
    }
  }
  return out;
}

// At 100 kHz, where the errors of a bench are not buried in noise.
std::string text_at_100_kHz(const std::string& name) {
  std::string text = read_text_file("protocols/library/" + name + ".json").value();
  const std::string slow = "\"frequency_Hz\": 1000,";
  return text.replace(text.find(slow), slow.size(), "\"frequency_Hz\": 100000,");
}

// Noise, what is made of it, and the scatter of repeats: the runs that give the truths have none.
bool is_of_noise(const std::string& metric) {
  return metric == "noise_fF" || metric == "limit_of_detection_kPa" ||
         metric == "repeatability_2sigma_percent";
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
  const BenchRun real = rehearse_with(what, seed, ErrorScope::everything, folder);
  const auto of_rig = results_of(rehearse_with(what, seed, ErrorScope::lasting, folder).analysis);
  const auto own = results_of(rehearse_with(what, seed, ErrorScope::specimen, folder).analysis);
  const double drift_fF_h = real.drawn["drift_fF_per_h"].get<double>();
  std::vector<Judged> out;
  for (auto& [name, judged] : results_of(real.analysis)) {
    if (is_of_noise(name) || !of_rig.contains(name) || !own.contains(name)) continue;
    judged.of_rig = of_rig.at(name).estimate.value;
    judged.own = own.at(name).estimate.value;
    if (name == "C0_pF") {  // refers to the middle of the baseline
      judged.of_rig += drift_fF_h * real.middle_of_baseline_s / 3600 * 1e-3;
      judged.own += drift_fF_h * real.middle_of_baseline_s / 3600 * 1e-3;
    }
    if (name == "baseline_drift_fF_per_h") judged.of_rig = judged.own = drift_fF_h;
    out.push_back(judged);
  }
  return out;
}

}  // namespace lcrig::worlds
