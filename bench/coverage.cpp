// SPDX-License-Identifier: Apache-2.0
// Measures how often the 95 % interval of a sensitivity contains the truth, by seeded rehearsals of
// a short form of static-frame, for each aperture. The truth is the least-squares slope of the
// specimen's own curve at the pressures that were held.
//
//   coverage_bench [RUNS=400] [FIRST_SEED=1]
#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "analysis/analysis.hpp"
#include "analysis/line_fit.hpp"
#include "base/strict_json.hpp"
#include "daemon/rehearse.hpp"
#include "model/bench_world.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"

namespace {

using namespace lcrig;

struct Tally {
  int runs = 0, inside = 0;
  double sum = 0, squares = 0, variance = 0, width = 0, truth = 0;
  void add(const RangeResult& r, double expected) {
    const Estimate& e = *r.sensitivity.estimate;
    ++runs;
    inside += (*e.interval)[0] <= expected && expected <= (*e.interval)[1] ? 1 : 0;
    sum += e.value - expected;
    squares += (e.value - expected) * (e.value - expected);
    variance += *e.standard_error * *e.standard_error;
    width += (*e.interval)[1] - (*e.interval)[0];
    truth += expected;
  }
};

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("not in the protocol: " + from);
  return text.replace(at, from.size(), to);
}

// The slope of the true curve at the targets of the levels in the range.
double true_slope(const TabulatedResponse& response, const RunAnalysis& a,
                  const PressureRange& range, double area_m2) {
  std::vector<LinePoint> points;
  for (const LevelResult& l : a.levels) {
    if (*l.target_kPa < range.from_kPa - 1e-6 || *l.target_kPa > range.to_kPa + 1e-6) continue;
    points.push_back({*l.target_kPa, response.capacitance_F(*l.target_kPa * 1e3 * area_m2) * 1e15,
                      static_cast<double>(l.readings)});
  }
  return fit_line(points).value().slope;
}

RunAnalysis rehearse_once(const std::string& protocol, const std::string& specimen,
                          std::uint64_t seed, const std::string& path) {
  RehearseRequest request;
  request.protocol_name = "static-frame";
  request.protocol_text = protocol;
  request.parameters = {{"readings", "6"}, {"within_s", "3"}, {"settle_s", "0.2"},
                        {"repeats", "3"},  {"levels", "10"},  {"rate_N_s", "1"}};
  request.specimen_name = "paper-1";
  request.specimen_text = specimen;
  request.seed = seed;
  request.db_path = path;
  const auto result = rehearse(request);
  if (!result || result->exit_status != ExitStatus::success) {
    throw std::runtime_error(result ? result->reason : result.error().what);
  }
  const auto db = open_read_only(path).value();
  auto analysis = analyse(db, result->run);
  if (!analysis) throw std::runtime_error(analysis.error().what);
  return std::move(*analysis);
}

void print(const char* aperture, const RangeResult& r, const Tally& t) {
  const double n = t.runs;
  const double scatter = std::sqrt(t.squares / n - t.sum * t.sum / n / n);
  fmt::print("{:<7} {:<11} {:>5} {:>9.2f} {:>10.4f} {:>10.4f} {:>10.4f} {:>12.4f}\n", aperture,
             fmt::format("{:g}-{:g}", r.range.from_kPa, r.range.to_kPa), t.runs, 100 * t.inside / n,
             t.truth / n, t.sum / n, scatter, std::sqrt(t.variance / n));
  std::fflush(stdout);
}

int number_of(std::string_view text) {
  int out = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), out);
  if (r.ec != std::errc() || out < 1) throw std::invalid_argument(std::string(text));
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? number_of(argv[1]) : 400;
  const int first = argc > 2 ? number_of(argv[2]) : 1;
  const std::string text = read_text_file("protocols/library/static-frame.json").value();
  const std::string specimen_text(shipped_specimens().front().text);
  const Specimen specimen = parse_specimen(specimen_text, "paper-1").value();
  const auto world = BenchWorld::make(specimen, 1e-4, Force::from_si(1.7), PlantConfig()).value();
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("coverage-{}", ::getpid());
  std::filesystem::create_directories(folder);
  fmt::print(
      "aperture range_kPa    runs  inside_%  true_slope       bias    scatter  mean_std_err"
      "  (fF/kPa)\n");
  for (const char* aperture : {"fast", "medium", "slow"}) {
    const std::string protocol =
        with(text, "\"aperture\": \"medium\"", fmt::format("\"aperture\": \"{}\"", aperture));
    std::map<std::size_t, Tally> tallies;
    RunAnalysis last;
    for (int seed = first; seed < first + runs; ++seed) {
      const std::string path = (folder / "run.db").string();
      for (const char* tail : {"", "-wal", "-shm"}) std::filesystem::remove(path + tail);
      last = rehearse_once(protocol, specimen_text, static_cast<std::uint64_t>(seed), path);
      for (std::size_t k = 0; k < last.ranges.size(); ++k) {
        tallies[k].add(last.ranges[k], true_slope(world->response(), last, last.ranges[k].range,
                                                  specimen.area_m2()));
      }
    }
    for (const auto& [k, tally] : tallies) print(aperture, last.ranges[k], tally);
  }
  std::filesystem::remove_all(folder);
}
