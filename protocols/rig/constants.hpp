// SPDX-License-Identifier: Apache-2.0
// The constants behind every tolerance of the watch: value, unit, origin. `lcrig watch checks`
// prints them, docs/watch.md contains them. What a frame, a config or a measurement states is not
// here.
#pragma once

#include <array>
#include <span>
#include <string_view>

namespace lcrig {

struct Constant {
  std::string_view name;
  double value;
  std::string_view unit, origin;
  constexpr operator double() const { return value; }
};

// Noise. An honest cell at 500 Hz is 1.8e9 samples in 1,000 hours; fewer than one of them is beyond
// 6.25 standard deviations (normal distribution).
inline constexpr Constant kSampleSigmas{
    "sample_sigmas", 6.25, "1", "at most one false alarm in 1,000 hours of samples at 500 Hz"};
// The difference of two samples has sqrt(2) times the noise of one.
inline constexpr double kDifferenceSigmas = 1.41421356 * kSampleSigmas.value;
inline constexpr Constant kNoiseSigmas{
    "noise_sigmas", 5, "1", "a comparison made once in a step: one in 3.5 million is beyond it"};
inline constexpr Constant kBoundSigmas{
    "bound_sigmas", 3, "1", "bounds of an estimate from one rest measurement, in standard errors"};

// Travel.
inline constexpr Constant kStanding_m{"standing", 10e-6, "m",
                                      "travel of a frame that stands; no source, chosen"};
inline constexpr Constant kHunting_m{
    "hunting", 3e-6, "m",
    "amplitude of a position loop: the error that class 1 of ISO 9513 allows"};
inline constexpr Constant kTravelSteps{"steps", 1.5, "travel steps",
                                       "a change by one step is rounding, by two is motion"};
inline constexpr Constant kCoarsestStep_m{
    "coarsest_step", 12e-6, "m", "a travel whose step is neither stated nor seen; assumed"};
inline constexpr Constant kPlace_m{
    "place", 1e-6, "m", "uncertainty of the place of contact, and of the deepest travel; assumed"};
inline constexpr Constant kSpeedAllowance{"speed_allowance", 1.2, "1",
                                          "of the ordered speed; no source, assumed"};
inline constexpr Constant kUnderWay_s{"under_way", 0.2, "s",
                                      "docs/frame-link.md: a sample may be 0.2 s under way"};
inline constexpr Constant kStall_s{
    "stall", 2, "s", "without progress, beside the reaction time of the frame; chosen"};
inline constexpr Constant kProgress{"progress", 0.1, "1",
                                    "part of the ordered way that counts as progress; chosen"};

// Force.
inline constexpr Constant kRelaxes{
    "relaxes", 0.3, "1", "part of a force that a specimen loses at once; foams lose a third"};
inline constexpr Constant kGivesBack{
    "gives_back", 0.05, "1", "part of a force that may return on a retreat; no source, assumed"};
inline constexpr Constant kLeastOfLimit{
    "least_of_limit", 0.02, "1", "part of the force limit below which a change does no harm"};
inline constexpr Constant kFalls{
    "falls", 0.4, "1", "fall from the largest force of a motion that no relaxation explains"};
inline constexpr Constant kStiffNear{
    "near", 0.25, "1", "least part of the measured stiffness near contact; a foam that buckles"};
inline constexpr Constant kNearForces{"near_forces", 4, "1",
                                      "multiple of the force at contact up to which `near` holds"};
inline constexpr Constant kStiffFar{
    "far", 0.05, "1", "the same beyond it: a foam that buckles keeps a tenth, half of it relaxes"};
inline constexpr Constant kReturns{"returns", 0.25, "1",
                                   "part of a force, at the depth where it was shown last"};
inline constexpr Constant kSooner{"sooner", 1.5, "1",
                                  "faster relaxation after a disturbance; no source, assumed"};
inline constexpr Constant kCreep_s{
    "creep", 0.01, "1/s",
    "creep as a part of the indentation while pressed; ten times as much held"};
inline constexpr double kHeldCreep = 10;
inline constexpr Constant kThermal_m_s{"thermal", 1e-9, "m/s",
                                       "expansion of rig and specimen: 3.6 um in an hour"};
inline constexpr Constant kJump{
    "jump", 0.1, "1", "part of the force that jumps at standstill; no relaxation is as sudden"};

inline constexpr std::array kConstants{
    &kSampleSigmas,   &kNoiseSigmas, &kBoundSigmas,    &kStanding_m, &kHunting_m,   &kTravelSteps,
    &kCoarsestStep_m, &kPlace_m,     &kSpeedAllowance, &kUnderWay_s, &kStall_s,     &kProgress,
    &kRelaxes,        &kGivesBack,   &kLeastOfLimit,   &kFalls,      &kStiffNear,   &kNearForces,
    &kStiffFar,       &kReturns,     &kSooner,         &kCreep_s,    &kThermal_m_s, &kJump};

}  // namespace lcrig
