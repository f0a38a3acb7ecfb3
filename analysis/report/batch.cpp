// SPDX-License-Identifier: Apache-2.0
#include "analysis/report/batch.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "analysis/line_fit.hpp"
#include "analysis/report/tables.hpp"
#include "base/near_word.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

Error no_batch(const Database& db, std::string_view name) {
  std::vector<std::string> names;
  if (const auto known = list_batches(db)) {
    for (const StoredBatch& batch : *known) names.push_back(batch.name);
  }
  std::string list;
  for (const auto& known : names) list += (list.empty() ? "" : ", ") + printable(known, 60);
  return Error(Errc::invalid_request,
               fmt::format("{}: no batch is called `{}`{} ({})", db.path(), printable(name, 60),
                           did_you_mean(name, names),
                           list.empty() ? "it has none" : "known: " + printable(list, 1000)));
}

// Frees the rows, many megabytes, that the batch's pictures and tables do not need.
void drop_rows(RunData& data) {
  data.readings = {};
  data.frame = {};
}

Result<BatchedResult> result_of(const Database& db, BatchListing listing,
                                const AnalysisOptions& options) {
  BatchedResult out;
  out.listing = std::move(listing);
  if (out.listing.runs.empty()) {
    out.no_run = fmt::format("it was not begun: {}", to_string(out.listing.state));
    return out;
  }
  const std::int64_t run = out.listing.runs.back();
  auto data = load_run_data(db, run);
  auto analysis = data ? analyse(*data, options) : fail(data.error());
  if (!analysis) {
    out.no_run = fmt::format("run {}: {}", run, analysis.error().what);
    return out;
  }
  out.run.emplace();
  drop_rows(*data);
  out.run->data = std::move(*data);
  out.run->analysis = std::move(*analysis);
  return out;
}

// The different estimands of the runs, each listed once.
std::vector<std::string> estimands_of(const std::vector<const RunAnalysis*>& runs,
                                      std::size_t metric) {
  std::vector<std::string> out;
  for (const RunAnalysis* run : runs) {
    const std::string& estimand = run->metrics().at(metric)->estimand;
    if (estimand.empty() || std::ranges::find(out, estimand) != out.end()) continue;
    out.push_back(estimand);
  }
  return out;
}

void compare_runs_of(BatchGroup& group, double confidence) {
  std::vector<const RunAnalysis*> good;
  for (const BatchedResult* result : group.results) {
    if (result->counts()) good.push_back(&result->run->analysis);
  }
  if (good.empty()) return;
  const auto reference = good.front()->metrics();
  for (std::size_t i = 0; i < reference.size(); ++i) {
    std::vector<Estimate> values;
    for (const RunAnalysis* analysis : good) {
      const Metric& metric = *analysis->metrics().at(i);
      if (metric) values.push_back(*metric.estimate);
    }
    if (values.empty()) continue;
    group.quantities.push_back(between_runs(values, confidence));
    group.quantities.back().label = report::metric_label(*good.front(), *reference[i]);
    group.quantities.back().estimands = estimands_of(good, i);
  }
}

std::vector<BatchGroup> groups_of(const std::vector<BatchedResult>& results, double confidence) {
  std::vector<BatchGroup> out;
  for (const BatchedResult& result : results) {
    const BatchListing& l = result.listing;
    const auto same = [&l](const BatchGroup& g) {
      return g.specimen == l.specimen_name && g.protocol == l.protocol_name &&
             g.parameters_json == l.parameters_json;
    };
    auto group = std::ranges::find_if(out, same);
    if (group == out.end()) {
      BatchGroup fresh;
      fresh.specimen = l.specimen_name;
      fresh.protocol = l.protocol_name;
      fresh.parameters_json = l.parameters_json;
      group = out.insert(out.end(), std::move(fresh));
    }
    group->results.push_back(&result);
  }
  const auto place = [](const BatchGroup& g) {
    const auto first = std::ranges::min_element(
        g.results, {}, [](const BatchedResult* r) { return r->listing.line; });
    return std::tuple((*first)->listing.line, g.specimen, g.protocol, g.parameters_json);
  };
  std::ranges::sort(out, {}, place);
  for (BatchGroup& group : out) compare_runs_of(group, confidence);
  return out;
}

nlohmann::json optional_number(const std::optional<double>& value) {
  if (!value) return nullptr;
  return *value;
}

nlohmann::json json_of_group(const BatchGroup& group) {
  nlohmann::json out{{"specimen", group.specimen},
                     {"protocol", group.protocol},
                     {"parameters", nlohmann::json::parse(group.parameters_json, nullptr, false)}};
  nlohmann::json quantities = nlohmann::json::array(), results = nlohmann::json::array();
  for (const BetweenRuns& q : group.quantities) {
    nlohmann::json one{{"quantity", q.label}, {"runs", q.runs}, {"mean", q.mean}};
    if (!q.estimands.empty()) one["estimands"] = q.estimands;
    one["scatter"] = optional_number(q.scatter);
    one["standard_error_within"] = optional_number(q.within);
    one["interval"] = nullptr;
    if (q.interval) one["interval"] = {(*q.interval)[0], (*q.interval)[1]};
    quantities.push_back(std::move(one));
  }
  for (const BatchedResult* result : group.results) {
    nlohmann::json one{{"entry", result->listing.entry},
                       {"position", result->listing.position},
                       {"line", result->listing.line},
                       {"repeat", result->listing.repeat},
                       {"state", to_string(result->listing.state)},
                       {"counts", result->counts()},
                       {"reason", result->run ? result->run->data.listing.reason : result->no_run}};
    one["run"] = nullptr;
    if (!result->listing.runs.empty()) one["run"] = result->listing.runs.back();
    results.push_back(std::move(one));
  }
  out["quantities"] = std::move(quantities);
  out["results"] = std::move(results);
  return out;
}

}  // namespace

bool BatchedResult::counts() const {
  return run && run->data.listing.exit_status == ExitStatus::success;
}

BetweenRuns between_runs(const std::vector<Estimate>& values, double confidence) {
  BetweenRuns out;
  out.runs = values.size();
  const auto n = static_cast<double>(values.size());
  double sum = 0, own = 0, known = 0;
  for (const Estimate& e : values) {
    sum += e.value;
    if (!e.standard_error) continue;
    own += *e.standard_error * *e.standard_error;
    ++known;
  }
  out.mean = sum / n;
  if (known > 0) out.within = std::sqrt(own / known);
  if (values.size() < 2) return out;
  double squares = 0;
  for (const Estimate& e : values) squares += (e.value - out.mean) * (e.value - out.mean);
  out.scatter = std::sqrt(squares / (n - 1));
  const double half = student_t_quantile(0.5 + confidence / 2, n - 1) * *out.scatter / std::sqrt(n);
  out.interval = {out.mean - half, out.mean + half};
  return out;
}

Result<BatchReport> load_batch_report(const Database& db, std::string_view name,
                                      const AnalysisOptions& options) {
  auto batch = find_batch(db, name);
  if (!batch) return fail(batch.error());
  if (!*batch) return fail(no_batch(db, name));
  BatchReport out;
  out.batch = std::move(**batch);
  out.confidence = options.confidence;
  auto entries = batch_entries(db, out.batch.batch);
  if (!entries) return fail(entries.error());
  out.results.reserve(entries->size());
  for (BatchListing& listing : *entries) {
    auto result = result_of(db, std::move(listing), options);
    if (!result) return fail(result.error());
    out.results.push_back(std::move(*result));
  }
  out.groups = groups_of(out.results, out.confidence);
  return out;
}

nlohmann::json to_json(const BatchReport& report) {
  nlohmann::json out{{"batch", report.batch.name},
                     {"file", report.batch.file_name},
                     {"order", to_string(report.batch.order)},
                     {"confidence", report.confidence}};
  out["seed"] = nullptr;
  if (report.batch.seed) out["seed"] = *report.batch.seed;
  out["groups"] = nlohmann::json::array();
  for (const BatchGroup& group : report.groups) out["groups"].push_back(json_of_group(group));
  return out;
}

}  // namespace lcrig
