// SPDX-License-Identifier: Apache-2.0
// frame-link/1: pure functions from text to values and back. Used by driver, link and simulator.
// docs/frame-link.md is the specification.
//
//   HELLO proto=1 side=gateway maker=... model=... serial=... version=...
//   #17 MOVEF force_N=1 speed_mm_s=0.016 guard_mm=3      OK #17      DONE #17 reason=target ...
//   S seq=101 n=2 t_s=4.02,4.04 force_N=0.1213,0.1229 travel_mm=2.5003,2.5006 flags=M
//
// The reader ignores unknown fields and accepts CR before LF and a leading '+'. It refuses a number
// that is not finite, a duplicate key, a control character and a line beyond 64 kB. The writer is
// strict.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "drivers/load_frame.hpp"
#include "drivers/zwick/line.hpp"

namespace lcrig::frame_link {

constexpr int kProtocol = 1;
constexpr int kRevision = 3;  // of the specification
constexpr Duration kHeartbeat = std::chrono::milliseconds(250);
constexpr Duration kSilence = std::chrono::seconds(1);

struct Hello {
  int protocol = kProtocol;
  int revision = kRevision;
  std::string side;  // "host" or "gateway"
  Identity identity;  // firmware: the gateway's version
  std::string origin;  // token for the zeros of force and travel; from revision 2 on
};
std::string format_hello(const Hello& hello);
Result<Hello> parse_hello(const Line& line);
// The line that an observer sends instead of HELLO.
std::string format_observe(const Hello& hello, double rate_Hz);

std::string format_caps(const FrameCapabilities& caps);
Result<FrameCapabilities> parse_caps(const Line& line);

// Commands, daemon to gateway. Every value must be finite.
std::string format_limits(std::int64_t number, const FrameLimits& limits);
std::string format_move(std::int64_t number, Length travel, Velocity speed);
std::string format_move_until(std::int64_t number, Force force, Velocity speed, Length guard);
std::string format_ramp(std::int64_t number, Force force, ForceRate rate);
std::string format_hold_travel(std::int64_t number);
std::string format_hold_force(std::int64_t number, Force force);
std::string format_zero(std::int64_t number, bool force, bool travel);
std::string format_rate(std::int64_t number, double rate_Hz);
std::string format_status(std::int64_t number);
constexpr std::string_view kStop = "STOP\n";
// The `text` of a DONE with reason=fault that the gateway's watchdog caused.
constexpr std::string_view kHostSilent = "host silent";
constexpr std::string_view kHostHeartbeat = "HB\n";

Result<FrameLimits> parse_limits(const Line& line);
Result<Length> length_of(const Line& line, std::string_view key);  // a key in mm, in metres
Result<Velocity> speed_of(const Line& line);  // speed_mm_s
Result<Force> force_of(const Line& line);  // force_N

// Answers and reports, gateway to daemon.
std::string format_ok(std::int64_t number);
std::string format_ok(std::int64_t number, std::string_view origin);  // the answer to ZERO
std::string format_err(std::int64_t number, std::string_view code, std::string_view text);
std::string format_done(std::int64_t number, const MotionOutcome& outcome);
std::string format_stopped(std::int64_t stops, const MotionOutcome& standing);
std::string format_event(std::string_view kind, std::string_view text);
std::string format_heartbeat(double device_time_s);
// Appends one line to `out`. There must be at least one sample.
void append_samples(std::string& out, std::span<const FrameSample> samples);

MotionOutcome parse_done(const Line& line);  // an unknown reason is a fault
// Appends the samples of a line and leaves `received` unset. Errors: garbled; `out` is then
// unchanged.
Result<> parse_samples(const Line& line, std::vector<FrameSample>& out);

}  // namespace lcrig::frame_link
