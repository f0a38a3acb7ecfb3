// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/queue_terms.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "base/day_time.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "protocols/batch/batch.hpp"
#include "tools/lcrig/when.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

Failure wrong(std::string what) {
  return Failure(kUsage, std::move(what), "lcrig queue add --help");
}

}  // namespace

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

}  // namespace lcrig::cli
