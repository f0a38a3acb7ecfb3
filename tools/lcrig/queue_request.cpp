// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/queue_request.hpp"

#include <fmt/ostream.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "base/day_time.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "storage/batches.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/live_line.hpp"
#include "tools/lcrig/protocol_request.hpp"
#include "tools/lcrig/when.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

Failure wrong(std::string what) {
  return Failure(kUsage, std::move(what), "lcrig queue add --help");
}

// Which pressure is meant, where probe and disc differ.
void print_area_words(std::ostream& out, const std::string& words) {
  if (!words.empty()) fmt::print(out, "{}\n", printable(words, kLongestWords));
}

}  // namespace

Outcome<std::int64_t> entry_number(const std::string& text, const GlobalOptions& global) {
  const auto number = number_from<std::int64_t>(text);
  if (number && *number >= 1) return *number;
  return Failure(kUsage,
                 fmt::format("ENTRY '{}' is not the number of an entry", printable(text, 60)),
                 next_command(global, {"queue", "list"}));
}

void PlaceOptions::declare(ArgumentList& list) {
  list.flag("--first", first_, "Before all that wait");
  list.flag("--last", last_, "Behind all that wait");
  list.option("--before", before_, kEntryWord, "Just before that one");
  list.option("--after", after_, kEntryWord, "Just behind that one");
}

Outcome<bool> PlaceOptions::put_into(json& params, const GlobalOptions& global) const {
  if (int{first_} + int{last_} + int{!before_.empty()} + int{!after_.empty()} > 1) {
    return Failure(kUsage, "--first, --last, --before and --after exclude each other: give one",
                   "lcrig queue --help");
  }
  params["place"] = first_ ? "first" : "last";
  for (const auto& [key, text] : {std::pair("before", before_), std::pair("after", after_)}) {
    if (text.empty()) continue;
    auto entry = entry_number(text, global);
    if (!entry) return entry.error();
    json at = json::object();
    at[key] = *entry;
    params["place"] = std::move(at);
  }
  return true;
}

void TermsOptions::declare(ArgumentList& list) {
  list.one_of("--on-failure", on_failure_, all_words<OnFailure>(),
              "What the queue does when it fails (default: hold)");
  list.option("--failures-max", failures_max_, "N",
              "So many failures in a row hold the queue (default: 3)");
  list.flag("--unattended", unattended_, "It may move the frame while nobody is there");
  list.option("--rest", rest_, "SECONDS", "Begin no sooner after the run before");
  list.option("--not-before", not_before_, "TIME", "Such as 22:00 or 2026-11-24 06:00");
  list.option("--not-after", not_after_, "TIME", "Later it does not begin any more");
  list.option("--between", between_, "FROM-TO",
              "Begin only at these times of the day: 18:00-06:00");
  list.option("--probe", probe_, "NAME", "Ask a person for this probe, unless it is on");
  list.option("--fixture", fixture_, "NAME", "Ask a person for this fixture, unless it is on");
}

Outcome<bool> TermsOptions::put_into(json& params, std::int64_t now_unix_s) const {
  if (!on_failure_.empty()) params["on_failure"] = on_failure_;
  if (unattended_) params["unattended"] = true;
  if (!probe_.empty()) params["probe"] = probe_;
  if (!fixture_.empty()) params["fixture"] = fixture_;
  if (!failures_max_.empty()) {
    const auto most = number_from<std::int64_t>(failures_max_);
    if (!most || *most < 1) {
      return wrong(fmt::format("--failures-max '{}' is not a number from 1 on",
                               printable(failures_max_, 60)));
    }
    params["failures_max"] = *most;
  }
  return put_times(params, now_unix_s);
}

Outcome<bool> TermsOptions::put_times(json& params, std::int64_t now_unix_s) const {
  if (!rest_.empty()) {
    const auto rest_s = number_from<double>(rest_);
    if (!rest_s || *rest_s < 0 || *rest_s > kLongestRest_s) {
      return wrong(fmt::format("--rest '{}' is not a number of seconds from 0 to {} (30 days)",
                               printable(rest_, 60), kLongestRest_s));
    }
    params["rest_s"] = *rest_s;
  }
  if (!between_.empty()) {
    if (!parse_day_window(between_)) {
      return wrong(fmt::format("--between '{}': expected two times of the day, such as 18:00-06:00",
                               printable(between_, 60)));
    }
    params["between"] = between_;
  }
  std::optional<std::int64_t> not_before, not_after;
  for (auto [option, text, at] : {std::tuple("--not-before", &not_before_, &not_before),
                                  std::tuple("--not-after", &not_after_, &not_after)}) {
    if (text->empty()) continue;
    *at = unix_time_of(*text, now_unix_s);
    if (*at) continue;
    return wrong(fmt::format("{} '{}' is no time: expected 22:00, 2026-11-24 or 2026-11-24 06:00",
                             option, printable(*text, 60)));
  }
  if (not_after && *not_after <= now_unix_s) {
    return wrong(
        fmt::format("--not-after '{}' is over: it could never begin", printable(not_after_, 60)));
  }
  if (not_before && not_after && *not_after < *not_before) {
    return wrong(fmt::format("--not-after '{}' is before --not-before '{}': it could never begin",
                             printable(not_after_, 60), printable(not_before_, 60)));
  }
  if (not_before) params["not_before_unix_s"] = *not_before;
  if (not_after) params["not_after_unix_s"] = *not_after;
  return true;
}

Outcome<ExitCode> call_queue(Context& context, std::string_view method, const json& params,
                             const std::function<void(std::ostream&, const json&)>& text) {
  auto answer = call_daemon(context, method, params, std::chrono::seconds(30));
  if (!answer) return answer.error();
  return show(context, *answer, [&](std::ostream& out) { text(out, *answer); });
}

Outcome<ExitCode> queue_run(Context& context, ControlClient& client, const json& params,
                            const RunRequest& request, const std::string& protocol,
                            const std::vector<std::string>& assignments) {
  // The daemon looks at the rig, and for a simulated one computes the specimen.
  auto answer = client.call("queue.add", params, kPlanPatience);
  if (!answer) return refused_run(context, answer.error(), request, protocol, assignments);
  return show(context, *answer, [&](std::ostream& out) {
    const json& plan = answer->at("plan");
    print_area_words(out, plan.value("pressure", std::string()));
    fmt::print(out, "entry {}", answer->value("entry", std::int64_t{0}));
    if (const json& s = plan.at("duration_s"); s.is_number()) {
      fmt::print(out, ": {} of machine time, {} readings\n", format_time(s.get<double>()),
                 plan.value("measure_readings", std::int64_t{0}));
    } else {
      fmt::print(out, ": not planned yet ({}); it is planned before it begins\n",
                 printable(plan.value("why_not", std::string()), kLongestWords));
    }
    context.console.next(next_command(context.global, {"queue", "list"}));
  });
}

json batch_params(const BatchRequest& batch) {
  json out{{"name", batch.name},          {"file", batch.file_name},
           {"table", batch.table},        {"order", to_string(batch.order)},
           {"protocols", json::object()}, {"specimens", json::object()}};
  if (batch.order != BatchOrder::given) out["seed"] = batch.seed;
  for (const auto& [word, file] : batch.protocols) {
    out["protocols"][word] = {{"name", file.name}, {"text", file.text}};
  }
  for (const auto& [word, file] : batch.specimens) {
    out["specimens"][word] = {{"name", file.name}, {"text", file.text}};
  }
  const BatchTerms& terms = batch.terms;
  if (terms.on_failure) out["on_failure"] = to_string(*terms.on_failure);
  if (terms.failures_max) out["failures_max"] = *terms.failures_max;
  if (terms.unattended) out["unattended"] = *terms.unattended;
  if (terms.rest_s) out["rest_s"] = *terms.rest_s;
  if (terms.probe) out["probe"] = *terms.probe;
  if (terms.fixture) out["fixture"] = *terms.fixture;
  return out;
}

Outcome<ExitCode> queue_batch(Context& context, const json& params, const BatchRequest& batch) {
  // The daemon plans each kind of run. A specimen that needs finite elements takes minutes.
  auto answer = call_daemon(context, "queue.add_batch", params, std::chrono::minutes(10));
  if (!answer) return answer.error();
  json all = *answer;
  all["batch"] = batch.name;
  all["order"] = to_string(batch.order);
  all["seed"] = batch.order == BatchOrder::given ? json() : json(batch.seed);
  return show(context, all, [&](std::ostream& out) {
    for (const json& words : answer->value("pressures", json::array())) {
      print_area_words(out, words.get<std::string>());
    }
    fmt::print(out, "batch {}: entries {} to {}, {}\n", printable(batch.name, kLongestName),
               answer->value("first_entry", std::int64_t{0}),
               answer->value("last_entry", std::int64_t{0}), order_words(batch.order, batch.seed));
    fmt::print(out, "{} of machine time, {} readings\n",
               format_time(answer->value("duration_s", 0.0)),
               answer->value("measure_readings", std::int64_t{0}));
    if (const auto unplanned = answer->value("unplanned", std::int64_t{0}); unplanned > 0) {
      fmt::print(out, "{} are not planned yet ({}); they are planned before they begin\n",
                 unplanned, printable(answer->value("why_not", std::string()), kLongestWords));
    }
    context.console.next(next_command(context.global, {"queue", "list"}));
  });
}

}  // namespace lcrig::cli
