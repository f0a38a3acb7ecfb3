// SPDX-License-Identifier: Apache-2.0
// Which readings lie between two equal read-backs of the meter's settings, and when the next
// read-back is due. Used by the Sampler.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/lcr_meter.hpp"
#include "events/payloads.hpp"

namespace lcrig {

class SettingsProof {
 public:
  // While readings are taken. A read-back of 48 ms (LcrCapabilities::read_back) then costs 1.6 % of
  // them.
  static constexpr Duration kInterval = std::chrono::seconds(3);
  // Values that look wrong are a reason to ask at most this often, because an open fixture gives
  // nothing else.
  static constexpr Duration kValueInterval = std::chrono::seconds(1);

  // Whether a read-back fits into a pause before a planned reading, with half a shortest conversion
  // to spare.
  static bool fits(Duration pause, const LcrCapabilities& meter) {
    return pause >= meter.read_back + std::chrono::milliseconds(30);
  }

  // A reading is stored. Its value, or what happened before it, may be a reason to ask at once.
  void taken(const LcrReading& reading, MonoTime now);
  void doubt() { doubt_ = true; }
  // A read-back that was equal proves all readings before it.
  void equal(MonoTime now);
  // The readings since the last equal read-back; nullopt: there are none.
  std::optional<UnprovenEvent> unproven(std::string why);

  bool is_doubted() const { return doubt_; }
  bool is_due(MonoTime now) const { return doubt_ || !equal_ || now - *equal_ >= kInterval; }
  bool has_open() const { return open_ > 0; }
  MonoTime last_asked() const { return last_; }  // while `has_open`
  // Whether a reading asked at or after this time turned out to be unproven.
  bool is_spoiled(MonoTime since) const { return spoiled_ && *spoiled_ >= since; }

 private:
  bool looks_wrong(const LcrReading& reading) const;

  bool doubt_ = false;
  std::optional<MonoTime> equal_;  // the last equal read-back
  std::int64_t open_ = 0;  // readings since then
  MonoTime first_{}, last_{};  // when the first and the last of them were asked
  std::optional<MonoTime> spoiled_;  // when the newest unproven reading was asked
  bool wrong_ = false;  // the last value looked wrong
  std::optional<double> value_;  // the last one
};

}  // namespace lcrig
