// SPDX-License-Identifier: Apache-2.0
#include "analysis/align.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/time.hpp"

namespace lcrig {

void WindowBefore::add(std::int64_t since_mono_ns, std::string_view settings_json) {
  using nlohmann::json;
  const json j = json::parse(settings_json, nullptr, false);
  if (!j.is_object() || !j.contains("trigger")) return;
  const auto time = j.find("conversion_time_s");
  const bool known = time != j.end() && time->is_number();
  const bool internal = j["trigger"] == "internal";
  since_.push_back(
      {since_mono_ns, internal && known ? from_seconds(time->get<double>()).count() : 0});
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
  auto state = track.at(out.middle_ns);
  if (!state) return fail(state.error());
  out.state = *state;
  const double window = static_cast<double>(first_byte_ns - begin) * 1e-9;
  const double spacing = static_cast<double>(out.state.spacing_ns) * 1e-9;
  out.uncertainty_s = std::sqrt((window * window + spacing * spacing) / 12);
  return out;
}

}  // namespace lcrig
