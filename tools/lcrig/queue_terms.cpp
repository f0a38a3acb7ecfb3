// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/queue_terms.hpp"

#include <nlohmann/json.hpp>

#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/lcrig/when.hpp"

namespace lcrig::cli {

using nlohmann::json;

void TermsOptions::declare(ArgumentList& list) {
  list.one_of("--on-failure", on_failure_, {"hold", "skip", "look", "repeat"},
              "What the queue does when it fails (default: hold)");
  list.option("--failures-max", failures_max_, "N",
              "So many failures in a row hold the queue (default: 3)");
  list.flag("--unattended", unattended_, "It may move the frame while nobody is there");
  list.number("--rest", rest_s_, "SECONDS", "Begin no sooner after the run before");
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
      return Failure(kUsage,
                     fmt::format("--failures-max '{}' is not a number from 1 on", failures_max_),
                     "lcrig queue add --help");
    }
    params["failures_max"] = *most;
  }
  return put_times(params, now_unix_s);
}

Outcome<bool> TermsOptions::put_times(json& params, std::int64_t now_unix_s) const {
  if (rest_s_) params["rest_s"] = *rest_s_;
  if (!between_.empty()) params["between"] = between_;
  const std::pair<const char*, const std::string&> times[] = {{"not_before", not_before_},
                                                              {"not_after", not_after_}};
  for (const auto& [key, text] : times) {
    if (text.empty()) continue;
    const auto at = unix_time_of(text, now_unix_s);
    if (!at) {
      const std::string option =
          key == std::string_view("not_before") ? "--not-before" : "--not-after";
      return Failure(kUsage,
                     fmt::format("{} '{}' is no time: expected 22:00, 2026-11-24 or 2026-11-24 "
                                 "06:00",
                                 option, printable(text, 60)),
                     "lcrig queue add --help");
    }
    params[std::string(key) + "_unix_s"] = *at;
  }
  return true;
}

}  // namespace lcrig::cli
