// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/terms.hpp"

#include <nlohmann/json.hpp>

#include "base/enum_words.hpp"
#include "base/text.hpp"
#include "daemon/control/params.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

void refuse(ParamsReader& in, const char* key, std::string_view expected) {
  in.fail_with(
      Error(Errc::invalid_request, fmt::format("{}: expected {}", in.pointer(key), expected)));
}

void read_failures(ParamsReader& in, QueueTerms& out) {
  std::string policy(to_string(out.on_failure));
  in.text("on_failure", policy);
  const auto known = parse_word(policy, OnFailure::repeat);
  if (known) out.on_failure = *known;
  if (!known) refuse(in, "on_failure", "hold, skip, look or repeat");
  in.integer("failures_max", out.failures_max);
  if (out.failures_max < 1 || out.failures_max > kMostFailuresInRow) {
    refuse(in, "failures_max", fmt::format("1 to {}", kMostFailuresInRow));
  }
}

void read_times(ParamsReader& in, QueueTerms& out) {
  in.number("rest_s", out.rest_s);
  if (!(out.rest_s >= 0 && out.rest_s <= kLongestRest_s)) {
    refuse(in, "rest_s", fmt::format("0 to {:.0f}", kLongestRest_s));
  }
  if (in.member("not_before_unix_s") != nullptr) {
    in.integer("not_before_unix_s", out.not_before_unix_s.emplace());
  }
  if (in.member("not_after_unix_s") != nullptr) {
    in.integer("not_after_unix_s", out.not_after_unix_s.emplace());
  }
  if (out.not_before_unix_s && out.not_after_unix_s &&
      *out.not_after_unix_s < *out.not_before_unix_s) {
    refuse(in, "not_after_unix_s", "a time after not_before_unix_s");
  }
  std::string between;
  if (in.member("between") != nullptr) in.text("between", between);
  if (between.empty()) return;
  out.between = parse_day_window(between);
  if (!out.between) refuse(in, "between", "two times of the day, such as 18:00-06:00");
}

}  // namespace

void read_terms(ParamsReader& in, QueueTerms& out) {
  read_failures(in, out);
  in.boolean("unattended", out.unattended);
  read_times(in, out);
  in.text("probe", out.probe, false, kNameMax);
  in.text("fixture", out.fixture, false, kNameMax);
}

QueueTerms with_row_terms(QueueTerms all, const BatchTerms& row) {
  if (row.on_failure) {
    all.on_failure = parse_word(*row.on_failure, OnFailure::repeat).value_or(all.on_failure);
  }
  if (row.failures_max) all.failures_max = *row.failures_max;
  if (row.unattended) all.unattended = *row.unattended;
  if (row.rest_s) all.rest_s = *row.rest_s;
  if (row.probe) all.probe = *row.probe;
  if (row.fixture) all.fixture = *row.fixture;
  return all;
}

json to_json(const QueueTerms& terms) {
  json out{{"on_failure", to_string(terms.on_failure)},
           {"failures_max", terms.failures_max},
           {"unattended", terms.unattended},
           {"rest_s", terms.rest_s},
           {"probe", terms.probe},
           {"fixture", terms.fixture},
           {"not_before_unix_s", nullptr},
           {"not_after_unix_s", nullptr},
           {"between", nullptr}};
  if (terms.not_before_unix_s) out["not_before_unix_s"] = *terms.not_before_unix_s;
  if (terms.not_after_unix_s) out["not_after_unix_s"] = *terms.not_after_unix_s;
  if (terms.between) out["between"] = to_string(*terms.between);
  return out;
}

Result<QueueTerms> parse_terms(std::string_view json_text) {
  const json value = json::parse(json_text, nullptr, false);
  QueueTerms out;
  ParamsReader in(value, "terms");
  read_terms(in, out);
  if (auto ok = in.finish(); !ok) return fail(Errc::garbled, "{}", ok.error().what);
  return out;
}

}  // namespace lcrig
