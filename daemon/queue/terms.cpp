// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/terms.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "daemon/control/params.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

constexpr std::array<std::string_view, 4> kPolicies{"hold", "skip", "look", "repeat"};

}  // namespace

std::string_view to_string(OnFailure policy) {
  return kPolicies[static_cast<std::size_t>(policy)];
}

std::optional<OnFailure> parse_on_failure(std::string_view word) {
  const auto* found = std::ranges::find(kPolicies, word);
  if (found == kPolicies.end()) return std::nullopt;
  return static_cast<OnFailure>(found - kPolicies.begin());
}

std::string to_json_text(const QueueTerms& terms) {
  const json out{{"on_failure", to_string(terms.on_failure)},
                 {"failures_max", terms.failures_max},
                 {"unattended", terms.unattended}};
  return out.dump();
}

Result<QueueTerms> parse_terms(std::string_view json_text) {
  const json value = json::parse(json_text, nullptr, false);
  QueueTerms out;
  std::string policy(to_string(out.on_failure));
  ParamsReader in(value, "terms");
  in.text("on_failure", policy);
  in.integer("failures_max", out.failures_max);
  in.boolean("unattended", out.unattended);
  const auto known = parse_on_failure(policy);
  if (!known) in.fail_with(Error(Errc::garbled, "terms/on_failure: unknown word"));
  if (auto ok = in.finish(); !ok) return fail(ok.error());
  out.on_failure = *known;
  return out;
}

}  // namespace lcrig
