// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/settings_proof.hpp"

#include <cmath>
#include <utility>

#include "base/flags.hpp"

namespace lcrig {

// No load changes a specimen by a factor of two within one reading.
bool SettingsProof::looks_wrong(const LcrReading& r) const {
  if ((r.flags & (lcr_flag::kPrimaryOverload | lcr_flag::kOutOfRange)) != 0) return true;
  if (!r.primary || !value_) return false;
  const double now = std::abs(*r.primary), before = std::abs(*value_);
  return now > 2 * before || before > 2 * now;
}

void SettingsProof::taken(const LcrReading& r, MonoTime now) {
  if (open_++ == 0) first_ = r.asked;
  last_ = r.asked;
  if ((r.flags & (lcr_flag::kAfterResync | lcr_flag::kAfterGap)) != 0 || r.slow) doubt_ = true;
  const bool wrong = looks_wrong(r);
  const bool asked_lately = equal_ && now - *equal_ < kValueInterval;
  if (wrong && !wrong_ && !asked_lately) doubt_ = true;
  wrong_ = wrong;
  value_ = r.primary;
}

void SettingsProof::equal(MonoTime now) {
  equal_ = now;
  open_ = 0;
  doubt_ = false;
}

std::optional<UnprovenEvent> SettingsProof::unproven(std::string why) {
  if (open_ == 0) return std::nullopt;
  UnprovenEvent out;
  out.asked_from_mono_ns = first_.time_since_epoch().count();
  out.asked_to_mono_ns = last_.time_since_epoch().count();
  out.readings = std::exchange(open_, 0);
  out.why = std::move(why);
  spoiled_ = last_;
  return out;
}

}  // namespace lcrig
