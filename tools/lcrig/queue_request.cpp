// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/queue_request.hpp"

#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/lcrig/live_line.hpp"
#include "tools/lcrig/next_command.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/protocol_request.hpp"

namespace lcrig::cli {

using nlohmann::json;

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

Outcome<ExitCode> call_queue(Context& context, const char* method, const json& params,
                             const std::function<void(std::ostream&, const json&)>& text) {
  auto client = ControlClient::connect(context);
  if (!client) return client.error();
  auto answer = client->call(method, params, std::chrono::seconds(30));
  if (!answer) return answer.error();
  return show(context, *answer, [&](std::ostream& out) { text(out, *answer); });
}

Outcome<ExitCode> queue_run(Context& context, ControlClient& client, const json& params,
                            const RunRequest& request, const std::string& protocol,
                            const std::vector<std::string>& assignments) {
  // The rig is looked at, and the specimen of a simulated one reckoned.
  auto answer = client.call("queue.add", params, std::chrono::minutes(2));
  if (!answer) return refused_run(context, answer.error(), request, protocol, assignments);
  return show(context, *answer, [&](std::ostream& out) {
    const json& plan = answer->at("plan");
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
  auto client = ControlClient::connect(context);
  if (!client) return client.error();
  // Each kind of run is planned; of a specimen that needs finite elements that takes minutes.
  auto answer = client->call("queue.add_batch", params, std::chrono::minutes(10));
  if (!answer) return answer.error();
  json all = *answer;
  all["batch"] = batch.name;
  all["order"] = to_string(batch.order);
  all["seed"] = batch.order == BatchOrder::given ? json() : json(batch.seed);
  return show(context, all, [&](std::ostream& out) {
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
