// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/reading_counts.hpp"

#include <algorithm>
#include <limits>

namespace lcrig {

namespace {

std::int64_t ns(MonoTime t) {
  return t.time_since_epoch().count();
}

}  // namespace

void ReadingCounts::add(const Committed& committed) {
  for (const CommittedReading& r : committed.readings) {
    ++readings_;
    if (r.counted) ++of_levels_;
    open_.push_back(r);
  }
  for (const RunEvent& event : committed.events) add(event);
}

void ReadingCounts::add(const RunEvent& event) {
  if (event.kind == EventKind::settings) prove_until(event.t);
  if (const auto* const back = event.as<ReadBackEvent>()) {
    is_read_back_ = true;
    if (back->equal) prove_until(event.t);
  }
  if (const auto* const span = event.as<UnprovenEvent>()) {
    take_back(span->asked_from_mono_ns, span->asked_to_mono_ns);
  }
  if (const auto* const lost = event.as<LevelAbandonedEvent>()) abandon(*lost);
}

void ReadingCounts::prove_until(MonoTime t) {
  while (!open_.empty() && open_.front().asked < t) open_.pop_front();
}

void ReadingCounts::take_back(std::int64_t from_mono_ns, std::int64_t to_mono_ns) {
  std::erase_if(open_, [&](const CommittedReading& r) {
    if (ns(r.asked) < from_mono_ns || ns(r.asked) > to_mono_ns) return false;
    --readings_;
    ++unproven_;
    auto& of_level = levels_.try_emplace(r.level, 0).first->second;
    if (r.counted && of_level) {
      --of_levels_;
      ++*of_level;
    }
    return true;
  });
}

void ReadingCounts::abandon(const LevelAbandonedEvent& lost) {
  auto& of_level = levels_.try_emplace(lost.level, 0).first->second;
  of_levels_ -= lost.readings.value_or(0) - of_level.value_or(0);
  of_level.reset();
}

void ReadingCounts::close() {
  constexpr auto kEver = std::numeric_limits<std::int64_t>::min();
  constexpr auto kForEver = std::numeric_limits<std::int64_t>::max();
  if (is_read_back_) take_back(kEver, kForEver);
  open_.clear();
}

}  // namespace lcrig
