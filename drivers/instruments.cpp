// SPDX-License-Identifier: Apache-2.0
// The conversions between enumerations and words that lcr_meter.hpp and load_frame.hpp declare.
#include <algorithm>
#include <array>
#include <utility>

#include "base/clock.hpp"
#include "base/decimal.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

namespace {

template <class Setting, std::size_t N>
std::string_view word_of(const SettingWords<Setting, N>& table, Setting setting) {
  const auto* const it =
      std::ranges::find(table, setting, &std::pair<std::string_view, Setting>::second);
  return it == table.end() ? std::string_view("?") : it->first;
}

}  // namespace

std::string_view to_string(LcrFunction f) {
  return word_of(kFunctionWords, f);
}
std::string_view to_string(Aperture a) {
  return word_of(kApertureWords, a);
}
std::string_view to_string(LcrTrigger t) {
  return word_of(kTriggerWords, t);
}

std::string_view to_string(MotionEnd e) {
  switch (e) {
    case MotionEnd::target: return "target";
    case MotionEnd::force_limit: return "force_limit";
    case MotionEnd::travel_limit: return "travel_limit";
    case MotionEnd::stopped: return "stopped";
    case MotionEnd::fault: return "fault";
  }
  return "fault";
}

std::optional<std::string_view> frame_fault_words(EventKind kind) {
  switch (kind) {
    case EventKind::device_estop: return "estop";
    case EventKind::device_drive_off: return "drive_off";
    case EventKind::device_shield: return "shield";
    case EventKind::device_drive_fault: return "drive_fault";
    case EventKind::motion_fault: return "a fault";
    default: return std::nullopt;
  }
}

SettingsEvent settings_event(const LcrSettings& s, Duration conversion_time) {
  SettingsEvent out;
  out.function = to_string(s.function);
  out.frequency_Hz = s.frequency.si();
  out.level_V = s.level.si();
  if (s.bias) out.bias_V = s.bias->si();
  out.aperture = to_string(s.aperture);
  out.average = s.average;
  out.trigger = to_string(s.trigger);
  out.conversion_time_s = shift_decimal(static_cast<double>(conversion_time.count()), -9);
  return out;
}

Task<Result<LcrSettings>> LcrMeter::restore(LcrSettings settings) {
  co_return co_await configure(std::move(settings));
}

Task<Result<CorrectionsOn>> LcrMeter::corrections() {
  co_return CorrectionsOn();
}

Task<Result<LcrSettings>> LcrMeter::reconnect() {
  co_return fail(Errc::invalid_request, "the meter has no port that could be opened again");
}

Task<Result<Identity>> LoadFrame::reconnect() {
  co_return fail(Errc::invalid_request, "the frame has no port that could be opened again");
}

Duration LcrCapabilities::conversion_time(const LcrSettings& s) const {
  return conversion[static_cast<std::size_t>(s.aperture)] * s.average;
}

}  // namespace lcrig
