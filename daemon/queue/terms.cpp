// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/terms.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "daemon/control/params.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

constexpr std::array<std::string_view, 4> kPolicies{"hold", "skip", "look", "repeat"};
constexpr double kLongestRest_s = 30 * 86400.0;

void refuse(ParamsReader& in, const char* key, std::string_view expected) {
  in.fail_with(
      Error(Errc::invalid_request, fmt::format("{}: expected {}", in.pointer(key), expected)));
}

void read_failures(ParamsReader& in, QueueTerms& out) {
  std::string policy(to_string(out.on_failure));
  in.text("on_failure", policy);
  const auto known = parse_on_failure(policy);
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

std::string_view to_string(OnFailure policy) {
  return kPolicies[static_cast<std::size_t>(policy)];
}

std::optional<OnFailure> parse_on_failure(std::string_view word) {
  const auto* found = std::ranges::find(kPolicies, word);
  if (found == kPolicies.end()) return std::nullopt;
  return static_cast<OnFailure>(found - kPolicies.begin());
}

void read_terms(ParamsReader& in, QueueTerms& out) {
  read_failures(in, out);
  in.boolean("unattended", out.unattended);
  read_times(in, out);
  in.text("probe", out.probe, false, kNameMax);
  in.text("fixture", out.fixture, false, kNameMax);
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
