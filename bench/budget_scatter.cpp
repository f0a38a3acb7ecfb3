// SPDX-License-Identifier: Apache-2.0
// Checks the budget. It compares predicted standard errors with the scatter of seeded rehearsals.
// It also compares predicted standard errors and half-widths with those that `analyze` gives. The
// cases are a short static test, the dynamic test with each aperture, and what the budget proposes
// for 1 %. Run it from the source tree; by default it makes 400 rehearsals of each.
//   build/bin/budget_scatter_bench [REHEARSALS [PROTOCOL|proposed]]
#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "base/log.hpp"
#include "budget/planned_run.hpp"
#include "budget/search.hpp"
#include "daemon/rehearse.hpp"
#include "model/specimen_file.hpp"
#include "protocols/file/parse.hpp"
#include "storage/database.hpp"

namespace lcrig {
namespace {

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream out;
  out << file.rdbuf();
  return out.str();
}

struct Case {
  std::string protocol;
  Aperture aperture = Aperture::fast;
  double frequency_Hz = 1000;
  ParameterValues parameters;
};

// The text of the protocol file with another setting, because a rehearsal takes text.
std::string text_of(const Case& c) {
  std::string text = read("protocols/library/" + c.protocol + ".json");
  const auto put = [&text](const std::string& key, const char* end, std::string_view value) {
    const auto begin = text.find(key) + key.size();
    text.replace(begin, text.find(end, begin) - begin, value);
  };
  put("\"aperture\": \"", "\"", to_string(c.aperture));
  put("\"frequency_Hz\": ", ",", fmt::format("{}", c.frequency_Hz));
  return text;
}

// Everything that one question to the budget needs.
struct Question {
  Protocol protocol;
  Environment environment;
  Rig rig;
  Plan plan;
  SpecimenCurve curve;
};

Result<Question> question_of(const Case& c, const std::string& specimen_text) {
  auto protocol = parse_protocol(text_of(c), c.protocol);
  if (!protocol) return fail(protocol.error());
  auto environment = bind_parameters(*protocol, c.parameters);
  if (!environment) return fail(environment.error());
  BenchRequest request;
  request.specimen_name = "paper-1";
  request.specimen_text = specimen_text;
  auto rig = bench_rig(request);
  if (!rig) return fail(rig.error());
  auto plan = make_plan(*protocol, *environment, *rig);
  if (!plan) return fail(plan.error());
  auto specimen = parse_specimen(specimen_text, "paper-1");
  if (!specimen) return fail(specimen.error());
  const Force most = Force::from_si(2 * plan->peak_force_N);
  auto curve = tabulate(*specimen, most, rig_for(*protocol, *rig).pressure);
  if (!curve) return fail(curve.error());
  return Question{std::move(*protocol), std::move(*environment), std::move(*rig), std::move(*plan),
                  std::move(*curve)};
}

Result<std::vector<Prediction>> predict(const Case& c, const std::string& specimen_text) {
  auto q = question_of(c, specimen_text);
  if (!q) return fail(q.error());
  auto run = plan_readings(q->protocol, q->environment, q->rig, q->plan, q->curve);
  if (!run) return fail(run.error());
  return predict_errors(*run);
}

// The case that `lcrig budget PROTOCOL --target 1%` proposes.
Result<Case> propose(const std::string& protocol, const std::string& specimen_text) {
  Case out;
  out.protocol = protocol;
  auto q = question_of(out, specimen_text);
  if (!q) return fail(q.error());
  BudgetQuestion question{q->protocol, q->environment, q->rig, q->curve, {}, {1e3, 1e5}, 0.01, {}};
  question.apertures = {Aperture::fast, Aperture::medium, Aperture::slow};
  const Budget budget = reckon_budget(question);
  if (!budget.cheapest) return fail(Errc::invalid_request, "{}: nothing proposed", protocol);
  out.aperture = budget.cheapest->aperture;
  out.frequency_Hz = budget.cheapest->frequency_Hz;
  fmt::print("{}: {:g} Hz, {}", protocol, out.frequency_Hz, to_string(out.aperture));
  for (const auto& [name, value] : budget.cheapest->parameters) {
    out.parameters[name] = fmt::format("{}", value);
    fmt::print(", {} {}", name, value);
  }
  fmt::print("\n");
  return out;
}

struct Moments {
  double n = 0, mean = 0, ss = 0;
  void add(double v) {
    n += 1;
    const double d = v - mean;
    mean += d / n;
    ss += d * (v - mean);
  }
  double deviation() const { return std::sqrt(ss / (n - 1)); }
};

// Moves the contact, because no specimen is mounted twice at the same micrometre. With another
// contact the readings fall on other instants of a loading.
std::string bench_text(std::uint64_t seed) {
  std::string text = read("daemon/rig/benches/paper.json");
  const std::string key = "\"contact_travel_mm\": ";
  const auto begin = text.find(key) + key.size();
  std::mt19937_64 random(seed);
  const double contact_mm = std::uniform_real_distribution(3.15, 3.25)(random);
  return text.replace(begin, text.find(',', begin) - begin, fmt::format("{:.6f}", contact_mm));
}

// Results of one rehearsal, in the order of the predictions.
Result<std::vector<Metric>> rehearse_once(const Case& c, const std::string& specimen_text,
                                          std::uint64_t seed, const std::string& db_path) {
  RehearseRequest request;
  request.protocol_name = c.protocol;
  request.protocol_text = text_of(c);
  request.parameters = c.parameters;
  request.specimen_name = "paper-1";
  request.specimen_text = specimen_text;
  request.seed = seed;
  request.bench_text = bench_text(seed);
  request.db_path = db_path;
  auto result = rehearse(request);
  if (!result) return fail(result.error());
  if (result->exit_status != ExitStatus::success) return fail(Errc::aborted, "{}", result->reason);
  auto db = open_read_only(db_path);
  if (!db) return fail(db.error());
  auto analysis = analyse(*db, result->run);
  if (!analysis) return fail(analysis.error());
  std::vector<Metric> out;
  for (const RangeResult& r : analysis->ranges) out.push_back(r.sensitivity);
  out.push_back(analysis->dynamic_range);
  return out;
}

Result<> compare_case(const Case& c, int rehearsals, const std::string& folder) {
  const std::string specimen_text = read("model/library/paper-1.json");
  auto predictions = predict(c, specimen_text);
  if (!predictions) return fail(predictions.error());
  std::vector<Moments> observed(predictions->size()), printed(predictions->size()),
      half(predictions->size());
  for (int seed = 1; seed <= rehearsals; ++seed) {
    const std::string db = folder + "/runs.db";
    auto metrics = rehearse_once(c, specimen_text, static_cast<std::uint64_t>(seed), db);
    for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(db + suffix);
    if (!metrics) return fail(metrics.error());
    for (std::size_t i = 0; i < metrics->size(); ++i) {
      const Metric& m = (*metrics)[i];
      if (m) observed[i].add(m.value());
      if (m && m.estimate->standard_error) printed[i].add(std::pow(*m.estimate->standard_error, 2));
      if (m && m.estimate->interval) half[i].add((*m.estimate->interval)[1] - m.value());
    }
  }
  for (std::size_t i = 0; i < predictions->size(); ++i) {
    const Prediction& p = (*predictions)[i];
    if (!p.reason.empty()) continue;
    const Moments& o = observed[i];
    fmt::print(
        "{:15} {:7} {:24} {:>10.4g} {:>10.4g} {:>11.4g} {:>11.4g} {:>7.3f} +-{:.3f} {:>8.3f} "
        "{:>8.3f}\n",
        c.protocol, to_string(c.aperture), p.quantity, p.value, o.mean, p.standard_error,
        o.deviation(), p.standard_error / o.deviation(), 1 / std::sqrt(2 * (o.n - 1)),
        p.standard_error / std::sqrt(printed[i].mean), p.half_width / half[i].mean);
  }
  return {};
}

std::vector<Case> cases() {
  std::vector<Case> out;
  for (const Aperture a : {Aperture::fast, Aperture::medium, Aperture::slow}) {
    Case c;
    c.protocol = "static-frame";
    c.aperture = a;
    c.parameters = {{"repeats", "2"}, {"readings", "10"}, {"within_s", "4"}};
    out.push_back(c);
  }
  for (const Aperture a : {Aperture::fast, Aperture::medium}) {
    Case c;
    c.protocol = "dynamic-cycles";
    c.aperture = a;
    c.parameters = {{"cycles", "3"}, {"gap_mm", "0.1"}};
    out.push_back(c);
  }
  return out;
}

int run(int rehearsals, const std::string& protocol) {
  set_up_logging("warn");
  const auto folder = std::filesystem::temp_directory_path() /
                      fmt::format("lcrig-budget-{}", static_cast<long>(::getpid()));
  std::filesystem::create_directories(folder);
  fmt::print("{:15} {:7} {:24} {:>10} {:>10} {:>11} {:>11} {:>15} {:>8} {:>8}\n", "protocol",
             "speed", "result", "expected", "mean", "predicted", "observed", "ratio", "of SE",
             "of half");
  int status = 0;
  std::vector<Case> list = cases();
  if (protocol == "proposed") {
    const std::string specimen_text = read("model/library/paper-1.json");
    list.clear();
    for (const char* name : {"static-frame", "dynamic-cycles"}) {
      const auto proposal = propose(name, specimen_text);
      if (!proposal) fmt::print("{}\n", proposal.error().what);
      if (proposal) list.push_back(*proposal);
    }
  }
  for (const Case& c : list) {
    if (!protocol.empty() && protocol != "proposed" && c.protocol != protocol) continue;
    if (auto done = compare_case(c, rehearsals, folder.string()); !done) {
      fmt::print(stderr, "{}\n", done.error().what);
      status = 1;
    }
  }
  std::filesystem::remove_all(folder);
  return status;
}

}  // namespace
}  // namespace lcrig

int main(int argc, char** argv) {
  int rehearsals = 400;
  if (argc > 1) std::from_chars(argv[1], argv[1] + std::strlen(argv[1]), rehearsals);
  return lcrig::run(std::max(rehearsals, 2), argc > 2 ? argv[2] : "");
}
