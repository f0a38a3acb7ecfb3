// SPDX-License-Identifier: Apache-2.0
#include "analysis/align.hpp"

#include <cmath>

#include "base/time.hpp"
#include "events/payloads.hpp"

namespace lcrig {

void WindowBefore::add(std::int64_t since_mono_ns, std::string_view settings_json) {
  const auto settings = from_json<SettingsEvent>(settings_json);
  if (!settings || !settings->trigger) return;
  const double window_s =
      settings->trigger == LcrTrigger::internal ? settings->conversion_time_s.value_or(0) : 0;
  since_.push_back({since_mono_ns, from_seconds(window_s).count()});
}

std::int64_t WindowBefore::at(std::int64_t asked_mono_ns) {
  while (next_ < since_.size() && since_[next_].mono_ns <= asked_mono_ns) ++next_;
  return next_ == 0 ? 0 : since_[next_ - 1].conversion_ns;
}

Result<Aligned> align(FrameTrack& track, std::int64_t before_ns, std::int64_t asked_ns,
                      std::int64_t first_byte_ns) {
  const std::int64_t begin = asked_ns - before_ns;
  Aligned out;
  out.middle_ns = begin + (first_byte_ns - begin) / 2;
  if (auto r = keep(track.at(out.middle_ns), out.state); !r) return fail(r.error());
  const double window = static_cast<double>(first_byte_ns - begin) * 1e-9;
  const double spacing = static_cast<double>(out.state.spacing_ns) * 1e-9;
  out.uncertainty_s =
      std::hypot(std::sqrt((window * window + spacing * spacing) / 12), out.state.clock_s);
  return out;
}

}  // namespace lcrig
