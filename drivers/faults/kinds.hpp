// SPDX-License-Identifier: Apache-2.0
// The table of all faults that a script can ask for: for each its name, when it may happen, its
// parameters and its effect on the bench. Used by the parser and the FaultPlayer.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/enum_words.hpp"
#include "drivers/faults/bench.hpp"
#include "drivers/line_fault.hpp"

namespace lcrig {

struct Fault;

enum class FaultTarget { meter, frame, bench };
template <>
inline constexpr EnumWords<3> kWordsOf<FaultTarget>{"meter", "frame", "bench"};

// counted: hits single events. lasting: goes on for a while. once: happens once and has no end.
enum class FaultShape { counted, lasting, once };

// The events that counted faults count: answers and set commands of the meter; transmissions,
// commands and ends of motions of the frame.
enum class FaultOccasion { none, answer, set, transmission, command, completion };

// The parameters of a fault, as bits.
namespace fault_parameter {
constexpr unsigned kDelay = 1U << 0U;
constexpr unsigned kFactor = 1U << 1U;
constexpr unsigned kGain = 1U << 2U;  // a factor that may be below 1
constexpr unsigned kBytes = 1U << 3U;
constexpr unsigned kJump = 1U << 4U;
constexpr unsigned kForce = 1U << 5U;
constexpr unsigned kSamples = 1U << 6U;
constexpr unsigned kText = 1U << 7U;
constexpr unsigned kIdentity = 1U << 8U;
constexpr unsigned kCode = 1U << 9U;
constexpr unsigned kOtherPort = 1U << 10U;
constexpr unsigned kForgets = 1U << 11U;
constexpr unsigned kStep = 1U << 12U;
constexpr unsigned kRate = 1U << 13U;
constexpr unsigned kSpeed = 1U << 14U;
constexpr unsigned kOrigin = 1U << 15U;
constexpr unsigned kNeedsEnd = 1U << 16U;  // not a parameter: for_s is required
constexpr unsigned kPanel = 1U << 17U;
}  // namespace fault_parameter

struct FaultScene {
  FaultBench& bench;
  FaultSurroundings* around;  // nullptr: none, and its faults have no effect
  const std::string& first_identity;  // identity of the bench's first meter
};

struct FaultKind {
  FaultTarget on;
  std::string_view name;
  FaultShape shape;
  unsigned parameters = 0;
  // Begins or ends a fault that is not counted.
  void (*act)(const Fault& fault, bool on, const FaultScene& scene) = nullptr;
  FaultOccasion counts = FaultOccasion::none;
  LineFault::Kind line = LineFault::Kind::none;  // the effect on the line that it counts
};
std::span<const FaultKind> fault_kinds();

}  // namespace lcrig
