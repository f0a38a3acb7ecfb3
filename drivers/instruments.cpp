// SPDX-License-Identifier: Apache-2.0
// Defaults for all meters and frames, which drivers may override.
#include <utility>

#include "base/clock.hpp"
#include "base/decimal.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

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
  out.aperture = s.aperture;
  out.average = s.average;
  out.trigger = s.trigger;
  out.conversion_time_s = shift_decimal(static_cast<double>(conversion_time.count()), -9);
  return out;
}

Task<Result<LcrSettings>> LcrMeter::restore(MeterState wanted) {
  co_return co_await configure(std::move(wanted.settings));
}

Task<Result<CorrectionsOn>> LcrMeter::corrections() {
  co_return CorrectionsOn();
}

Task<Result<Reconnected>> LcrMeter::reconnect(MeterState /*wanted*/) {
  co_return fail(Errc::invalid_request, "the meter has no port that could be opened again");
}

Task<Result<Identity>> LoadFrame::reconnect() {
  co_return fail(Errc::invalid_request, "the frame has no port that could be opened again");
}

Duration LcrCapabilities::conversion_time(const LcrSettings& s) const {
  return conversion[static_cast<std::size_t>(s.aperture)] * s.average;
}

}  // namespace lcrig
