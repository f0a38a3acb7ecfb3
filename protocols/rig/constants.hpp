// SPDX-License-Identifier: Apache-2.0
// The constants behind the verdicts of the watch: value, unit, origin. `lcrig watch checks` prints
// them, docs/watch.md contains them, and tools/check/constants refuses numbers elsewhere. What a
// frame, a config or a measurement states is not here.
#pragma once

#include <array>
#include <string_view>

#include "base/time.hpp"

namespace lcrig {

struct Constant {
  std::string_view name;
  double value;
  std::string_view unit, origin;
  constexpr operator double() const { return value; }
  constexpr int count() const { return static_cast<int>(value); }
  Duration duration() const { return from_seconds(value); }
};

// Noise. An honest cell at 500 Hz is 1.8e9 samples in 1,000 hours; fewer than one of them is beyond
// 6.25 standard deviations (normal distribution).
inline constexpr Constant kSampleSigmas{
    "sample_sigmas", 6.25, "1", "at most one false alarm in 1,000 hours of samples at 500 Hz"};
inline constexpr Constant kNoiseSigmas{
    "noise_sigmas", 5, "1", "a comparison made once in a step: one in 3.5 million is beyond it"};
inline constexpr Constant kBoundSigmas{
    "bound_sigmas", 3, "1", "bounds of an estimate from one rest measurement, in standard errors"};
inline constexpr Constant kFewSamples{
    "few_samples", 15, "1", "fits chi-squared: 2.02 for 14 degrees of freedom, 1.23 for 50"};
inline constexpr Constant kAgainSigmas{
    "again_sigmas", 3.6, "1", "another estimate is larger in fewer than one of 1,000 pairs"};
inline constexpr Constant kNoiseKnown{
    "noise_known", 0.7, "1",
    "part of the noise that a short rest measurement surely sees; measured"};
inline constexpr Constant kHidden{"hidden", 0.5, "steps",
                                  "of noise below it 20 samples may show one value only"};
inline constexpr Constant kHiddenAgain{
    "hidden_again", 1.5, "steps",
    "the same for another rest measurement, whose step may flip more"};
inline constexpr Constant kBlocks{"blocks", 4, "1",
                                  "blocks of samples whose means show correlation (batch means)"};
inline constexpr Constant kInBlock{"in_block", 3, "samples", "the least in such a block"};
inline constexpr Constant kRestSamples{"rest_samples", 10, "samples",
                                       "the least in a rest measurement; chosen"};

// A frozen cell: more equal forces in a row than a healthy one shows.
inline constexpr Constant kFrozenChance{"frozen_chance", 1e-12, "1",
                                        "a year of samples at 500 Hz is 2e10"};
inline constexpr Constant kEqualSteps{
    "equal_steps", 0.38, "1",
    "chance of two equal samples is 0.28 steps per noise; the noise is an estimate"};
inline constexpr Constant kCoarsestNoise{
    "coarsest_noise", 1.8, "1", "steps per noise beyond which a healthy cell repeats itself, too"};
inline constexpr Constant kNoiseSeen{
    "noise_seen", 0.85, "1",
    "part of the noise that is certain where the step is coarse; measured"};
inline constexpr Constant kFrozenLeast{"frozen_least", 5, "samples",
                                       "fewer may be chance in a short rest measurement; chosen"};
inline constexpr Constant kFrozenMargin{
    "frozen_margin", 4, "1", "times the longest run at rest: a gateway may repeat samples"};
inline constexpr Constant kFrozenAssumed{"frozen_assumed", 25, "samples",
                                         "in a plan, before a rest measurement; chosen"};

// The link.
inline constexpr Constant kBatch_s{"batch", 0.1, "s",
                                   "docs/frame-link.md: samples come in batches of 100 ms"};
inline constexpr Constant kUnderWay_s{"under_way", 0.2, "s",
                                      "docs/frame-link.md: a sample may be 0.2 s under way"};
inline constexpr Constant kSilent_s{
    "silent", 0.5, "s", "two batches with their jitter; no force or no travel is older"};
inline constexpr Constant kSilentPeriods{"silent_periods", 3, "samples",
                                         "the same at slow rates; chosen"};
inline constexpr Constant kNewSamples{"new_samples", 2, "samples",
                                      "an older force is not the present one; one may be missing"};
inline constexpr Constant kOldSamples_s{
    "old_samples", 0.25, "s",
    "after a zero, samples from before it; two batches with their jitter"};
inline constexpr Constant kHostLatency_s{"host_latency", 0.02, "s",
                                         "docs/frame-link.md: to see a sample and send STOP"};
inline constexpr Constant kLinkSilence_s{
    "link_silence", 1.02, "s", "docs/frame-link.md: until a gateway that hears nothing stops"};
inline constexpr Constant kFilterTimes{"filter_times", 3, "1",
                                       "time constants after which 95 % of a step are shown"};
inline constexpr Constant kSettleTimes{"settle_times", 5, "1",
                                       "time constants after which 99 % of a step are shown"};

// Travel.
inline constexpr Constant kStanding_m{"standing", 10e-6, "m",
                                      "travel of a frame that stands; no source, chosen"};
inline constexpr Constant kHunting_m{
    "hunting", 3e-6, "m",
    "amplitude of a position loop: the error that class 1 of ISO 9513 allows"};
inline constexpr Constant kStandingPart{"standing_part", 0.1, "1",
                                        "of the force limit: a frame that creeps may add no more"};
inline constexpr Constant kWithForce{
    "with_force", 0.2, "1", "of `standing`, if the force changes together with the travel; chosen"};
inline constexpr Constant kTravelSteps{"steps", 1.5, "steps",
                                       "a change by one step is rounding, by two is motion"};
inline constexpr Constant kCoarsestStep_m{
    "coarsest_step", 12e-6, "m", "a travel whose step is neither stated nor seen; assumed"};
inline constexpr Constant kPlace_m{
    "place", 1e-6, "m", "uncertainty of the place of contact, and of the deepest travel; assumed"};
inline constexpr Constant kSpeedAllowance{"speed_allowance", 1.2, "1",
                                          "of the ordered speed; no source, assumed"};
inline constexpr Constant kStall_s{
    "stall", 2, "s", "without progress, beside the reaction time of the frame; chosen"};
inline constexpr Constant kQuarters{"quarters", 4, "1",
                                    "parts of that time, so that a stall is noticed soon after it"};
inline constexpr Constant kProgress{"progress", 0.1, "1",
                                    "part of the ordered way that counts as progress; chosen"};
inline constexpr Constant kLeastRate{
    "least_rate", 0.2, "1",
    "the same of the force of a loop, or of what a contact pushes back; chosen"};
inline constexpr Constant kBrakes{
    "brakes", 0.5, "1", "of the ordered speed; a slower frame brakes, and its force relaxes"};

// Force.
inline constexpr Constant kRelaxes{
    "relaxes", 0.3, "1", "part of a force that a specimen loses at once; foams lose a third"};
inline constexpr Constant kGivesBack{
    "gives_back", 0.05, "1", "part of a force that may return on a retreat; no source, assumed"};
inline constexpr Constant kSooner{"sooner", 1.5, "1",
                                  "faster relaxation after a disturbance; no source, assumed"};
inline constexpr Constant kFalls{
    "falls", 0.4, "1", "fall from the largest force of a motion that no relaxation explains"};
inline constexpr Constant kLeastOfLimit{
    "least_of_limit", 0.02, "1", "part of the force limit below which a change does no harm"};
inline constexpr Constant kOfLimit{"of_limit", 0.01, "1",
                                   "the same where it counts as a load, or as the end of a motion"};
inline constexpr Constant kStiffNear{
    "near", 0.25, "1", "least part of the measured stiffness near contact; a foam that buckles"};
inline constexpr Constant kNearForces{"near_forces", 4, "1",
                                      "multiple of the force at contact up to which `near` holds"};
inline constexpr Constant kStiffFar{
    "far", 0.05, "1", "the same beyond it: a foam that buckles keeps a tenth, half of it relaxes"};
inline constexpr Constant kReturns{"returns", 0.25, "1",
                                   "part of a force, at the depth where it was shown last"};
inline constexpr Constant kCreep_s{"creep", 0.01, "1/s",
                                   "creep as a part of the indentation while pressed"};
inline constexpr Constant kHeldCreep{"held_creep", 10, "1",
                                     "times as much under a held force; no source, assumed"};
inline constexpr Constant kThermal_m_s{"thermal", 1e-9, "m/s",
                                       "expansion of rig and specimen: 3.6 um in an hour"};
inline constexpr Constant kSettles{
    "settles", 0.1, "1", "part of the force, from the stop of a motion to the next sample; chosen"};
inline constexpr Constant kTwice{"twice", 2, "samples", "a single sample may be a spike"};

// A jump at standstill: the medians of two short intervals. They are so far apart that no knock
// lasts as long, and no relaxation is as quick.
inline constexpr Constant kJump{"jump", 0.1, "1",
                                "part of the force that jumps; no relaxation is as sudden"};
inline constexpr Constant kOneStep{
    "one_step", 0.6, "1", "a jump has a single step of at least this part; relaxation has many"};
inline constexpr Constant kJumpSettled_s{"jump_settled", 1.5, "s",
                                         "after a motion or a zero; chosen"};
inline constexpr Constant kJumpApart_s{"jump_apart", 1, "s",
                                       "between the two intervals; a knock is shorter"};
inline constexpr Constant kLook_s{"look", 0.3, "s",
                                  "a short rest measurement, and each of the intervals"};
inline constexpr Constant kObserved_s{"observed", 0.5, "s",
                                      "a shorter observation shows no relaxation; chosen"};
inline constexpr Constant kSmooth{"smooth", 0.2, "1",
                                  "weight of a new sample in the smoothed force at standstill"};
inline constexpr Constant kSmoothSquare{"smooth_square", 0.05, "1",
                                        "weight of its square in the noise"};

// Contact.
inline constexpr Constant kFirstStep_m{
    "first_step", 0.2e-6, "m", "first step back from contact; each is twice as far as the last"};
inline constexpr Constant kStepSpeed_m_s{"step_speed", 10e-6, "m/s",
                                         "fastest step back; a faster one rings"};
inline constexpr Constant kFarthest_m{"farthest", 0.5e-3, "m", "farthest step back; chosen"};
inline constexpr Constant kEnough{"enough", 0.3, "1",
                                  "of the force at contact; below it further steps show nothing"};
inline constexpr Constant kLeft{"left", 0.1, "1",
                                "of the force at contact; below it the contact may be lost"};
inline constexpr Constant kMore{"more", 1.2, "1",
                                "of the force at contact; a larger one on a retreat is no contact"};
inline constexpr Constant kGone{"gone", 0.05, "1", "of the force; a smaller fall shows no motion"};
inline constexpr Constant kLeastFelt{"least_felt", 0.2, "1",
                                     "of the threshold, at standstill; less is no contact"};
inline constexpr Constant kTail{"tail", 1.5, "1",
                                "a contact that starts softly is left later than its slope says"};
inline constexpr Constant kRelaxed{
    "relaxed", 0.02, "1", "of the force; a smaller fall from look to look counts as relaxed"};
inline constexpr Constant kSlow_s{"slow", 0.15, "1/s",
                                  "of the force; a faster relaxation spoils the slope"};
inline constexpr Constant kMostLooks{"most_looks", 12, "1", "at contact, while it relaxes"};
inline constexpr Constant kBeyondStep{"beyond_step", 1.01, "steps",
                                      "a way of one step may be none"};
inline constexpr Constant kDriftTime_s{
    "drift_time", 3, "s", "a rest measurement that measures drift, or sees a live cell"};
inline constexpr Constant kDriftChanges{
    "drift_changes", 2, "1", "by which drift changes from one rest measurement to the next"};
inline constexpr Constant kDriftOfThreshold{
    "drift_of_threshold", 0.25, "1",
    "drift during one leg of a search, as a part of the threshold"};
inline constexpr Constant kLeastLeg_s{"least_leg", 1, "s",
                                      "of a search; a shorter one would mostly stop and start"};
inline constexpr Constant kAttempts{"attempts", 5, "1",
                                    "of a search that touches something other than a specimen"};
inline constexpr Constant kNoiseGrown{"noise_grown", 1.5, "1", "the noise since the plan was made"};

// The difference of two samples has sqrt(2) times the noise of one.
inline constexpr double kDifferenceSigmas = 1.41421356 * kSampleSigmas.value;

inline constexpr std::array kConstants{
    &kSampleSigmas,   &kNoiseSigmas,   &kBoundSigmas,   &kFewSamples,     &kAgainSigmas,
    &kNoiseKnown,     &kHidden,        &kHiddenAgain,   &kBlocks,         &kInBlock,
    &kRestSamples,    &kFrozenChance,  &kEqualSteps,    &kCoarsestNoise,  &kNoiseSeen,
    &kFrozenLeast,    &kFrozenMargin,  &kFrozenAssumed, &kBatch_s,        &kUnderWay_s,
    &kSilent_s,       &kSilentPeriods, &kNewSamples,    &kOldSamples_s,   &kHostLatency_s,
    &kLinkSilence_s,  &kFilterTimes,   &kSettleTimes,   &kStanding_m,     &kHunting_m,
    &kStandingPart,   &kWithForce,     &kTravelSteps,   &kCoarsestStep_m, &kPlace_m,
    &kSpeedAllowance, &kStall_s,       &kQuarters,      &kProgress,       &kLeastRate,
    &kBrakes,         &kRelaxes,       &kGivesBack,     &kSooner,         &kFalls,
    &kLeastOfLimit,   &kOfLimit,       &kStiffNear,     &kNearForces,     &kStiffFar,
    &kReturns,        &kCreep_s,       &kHeldCreep,     &kThermal_m_s,    &kSettles,
    &kTwice,          &kJump,          &kOneStep,       &kJumpSettled_s,  &kJumpApart_s,
    &kLook_s,         &kObserved_s,    &kSmooth,        &kSmoothSquare,   &kFirstStep_m,
    &kStepSpeed_m_s,  &kFarthest_m,    &kEnough,        &kLeft,           &kMore,
    &kGone,           &kLeastFelt,     &kTail,          &kRelaxed,        &kSlow_s,
    &kMostLooks,      &kBeyondStep,    &kDriftTime_s,   &kDriftChanges,   &kDriftOfThreshold,
    &kLeastLeg_s,     &kAttempts,      &kNoiseGrown};

}  // namespace lcrig
