// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig-sim/random_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "base/number.hpp"

namespace lcrig::sim {

namespace {

using nlohmann::json;

// Draws random numbers that are the same for a seed with every standard library.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {
    for (int i = 0; i < 8; ++i) random_();
  }
  double even(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11U) * 0x1p-53);
  }
  double scale(double low, double high) { return std::exp(even(std::log(low), std::log(high))); }
  bool chance(double p) { return even(0, 1) < p; }

 private:
  std::mt19937_64 random_;
};

double round_to(double value, int digits) {
  if (value == 0) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - digits + 1);
  return std::round(value / unit) * unit;
}

// The facts for the plan are drawn on the safe side of the truth.
struct Contact {
  double frame_N_m = 0, specimen_N_m = 0, curvature_1_m = 0;
};

Contact draw_contact(Draw& draw, double limit_N, bool curved) {
  const double stiffness = draw.scale(1e3, 1000e3);
  const double share = draw.even(0.05, 0.9);  // the frame's share of the compliance
  // Factor by which the specimen's stiffness grows up to twice the limit.
  const double growth = draw.chance(0.5) ? draw.scale(1, 1.5) : draw.scale(1, 4);
  Contact c;
  c.frame_N_m = stiffness / share;
  c.specimen_N_m = stiffness / (1 - share);
  // k(F) = k sqrt(1 + 4 c F / k)
  if (curved) c.curvature_1_m = (growth * growth - 1) * c.specimen_N_m / (8 * limit_N);
  return c;
}

void draw_cell(Draw& draw, const RigOptions& options, RandomRig& rig) {
  const std::uint32_t quirks = rig.quirks;
  PlantConfig& p = rig.plant;
  p.force_nominal_N = round_to(draw.scale(5, 500), 2);
  p.force_noise_N = p.force_nominal_N * draw.scale(3e-6, 1e-4);
  p.force_resolution_N = std::pow(10, std::floor(std::log10(p.force_noise_N)));
  rig.limit_N =
      round_to(std::clamp(draw.scale(0.3, 20), 60 * p.force_noise_N, 0.8 * p.force_nominal_N), 2);
  const double drawn = draw.chance(0.5) ? 1 : 0.5;
  rig.force_class_percent = options.force_class_percent.value_or(drawn);
  const double class_part = rig.force_class_percent / 100;
  const double offset_N = draw.even(-0.08, 0.08) * rig.limit_N;
  const double drift_N_s = draw.even(-0.3, 0.3) * class_part / 10 * p.force_nominal_N / 600;
  const double gain = 1 + draw.even(-0.9, 0.9) * class_part;
  if ((quirks & kOffset) != 0) p.force_offset_N = offset_N;
  if ((quirks & kDrift) != 0) p.force_drift_N_s = drift_N_s;
  if ((quirks & kGain) != 0) p.force_gain = gain;
}

void draw_travel(Draw& draw, std::uint32_t quirks, RandomRig& rig) {
  PlantConfig& p = rig.plant;
  const double origin_m = std::round(draw.even(-150, 150)) * 1e-3;
  const double stroke_m = std::round(draw.even(20, 120)) * 1e-3;
  const double above_m = draw.even(6e-3, stroke_m - 1e-3);
  const double gap_m = draw.scale(0.3e-3, 15e-3);
  p.travel_min_m = (quirks & kOddTravel) != 0 ? origin_m : 0;
  p.travel_max_m = p.travel_min_m + stroke_m;
  p.contact_travel_m = p.travel_min_m + above_m;
  rig.gap_m = std::min(gap_m, above_m - 0.5e-3);
  p.travel_resolution_m = draw.chance(0.5) ? 1e-7 : 1e-8;
  p.speed_max_m_s = round_to(draw.scale(1e-3, 50e-3), 2);
  rig.frame.speed_min_m_s = draw.chance(0.5) ? 1e-8 : 1e-7;
}

void draw_stop(Draw& draw, std::uint32_t quirks, RandomRig& rig) {
  PlantConfig& p = rig.plant;
  const double reaction_s = draw.scale(0.5e-3, 80e-3);
  const double polled = draw.even(0.3, 0.9);
  p.deceleration_m_s2 = draw.scale(5e-3, 0.5);
  p.drive_lag_s = reaction_s;
  if ((quirks & kPolled) == 0) return;
  rig.frame.watch_period_s = polled * reaction_s;
  p.drive_lag_s = reaction_s - rig.frame.watch_period_s;
}

void draw_loop(Draw& draw, std::uint32_t quirks, RandomRig& rig) {
  ZwickSimSettings& f = rig.frame;
  f.force_hold = (quirks & kNoLoop) == 0;
  f.approach_m_s = draw.scale(2e-6, 0.2e-3);
  f.loop_rate_max_N_s = round_to(draw.scale(0.5, 20), 2);
  const double lag_s = draw.scale(1e-3, 30e-3);
  const double ripple_N = rig.plant.force_noise_N * draw.even(0, 4);
  if ((quirks & kLoopWavers) == 0) return;
  f.loop_lag_s = lag_s;
  f.loop_ripple_N = ripple_N;
  f.loop_lands = true;
}

void draw_link(Draw& draw, std::uint32_t quirks, RandomRig& rig) {
  ZwickSimSettings& f = rig.frame;
  f.rate_max_Hz = std::round(draw.scale(10, 500));
  f.device_clock_start_s = std::round(draw.even(0, 1e5));
  f.device_clock_ppm = std::round(draw.even(-50, 50));
  const double delay_s = draw.even(0, 0.05), jitter_s = draw.even(0, 0.08);
  const double time = draw.even(0, 0.03), force = draw.even(0, 0.05), travel = draw.even(0, 0.05);
  const double answers_s = draw.even(0, 0.3);
  const int newer = rig.seed % 2 == 0 ? 2 : frame_link::kRevision;  // changes no other draw
  f.revision = (quirks & kRevision1) != 0 ? 1 : newer;
  if ((quirks & kLate) != 0) {
    f.line_delay_s = delay_s;
    f.line_jitter_s = jitter_s;
  }
  if ((quirks & kMissing) != 0) {
    f.missing_time = time;
    f.missing_force = force;
    f.missing_travel = travel;
  }
  if ((quirks & kSlowAnswers) != 0) f.answer_delay_s = answers_s;
}

// The values of CAPS: each is a bound that holds in the worst case.
void tell_capabilities(Draw& draw, RandomRig& rig) {
  const PlantConfig& p = rig.plant;
  const ZwickSimSettings& f = rig.frame;
  FrameCapabilities c;
  c.motion = c.zero_force = c.zero_travel = true;
  c.device_stop = f.watch_period_s == 0;
  c.force_hold = f.force_hold;
  c.force_max = Force::from_si(p.force_nominal_N);
  c.speed_min = Velocity::from_si(f.speed_min_m_s);
  c.speed_max = Velocity::from_si(p.speed_max_m_s);
  c.travel_min = Length::from_si(p.travel_min_m);
  c.travel_max = Length::from_si(p.travel_max_m);
  c.sample_rate_max_Hz = f.rate_max_Hz;
  c.reaction = from_seconds(round_to(rig.reaction_s() * draw.scale(1.02, 1.6), 3));
  c.deceleration = Acceleration::from_si(round_to(p.deceleration_m_s2 * draw.even(0.6, 0.98), 3));
  ForceLoop loop;
  const double margin = draw.even(1.02, 1.5), stiffness_N_m = draw.scale(10e3, 3000e3);
  const double contact_N = 5 * std::max(p.force_resolution_N, p.force_noise_N);
  loop.approach = Velocity::from_si(f.approach_m_s * margin);
  loop.contact = Force::from_si(contact_N * margin);
  loop.rate_max = ForceRate::from_si(f.loop_rate_max_N_s);
  loop.lag = from_seconds(f.loop_lag_s * margin);
  loop.ripple = Force::from_si(f.loop_ripple_N * margin);
  loop.stiffness_max = Stiffness::from_si(round_to(stiffness_N_m, 2));
  const bool stated = draw.chance(0.6);
  if (f.force_hold && f.revision >= 2) c.force_loop = loop;
  if (f.force_hold && f.revision < 2 && stated) rig.force_loop = loop;
  rig.frame.declared = c;
}

// A gateway of revision 3 states what its samples show.
void tell_steps(RandomRig& rig) {
  if (rig.frame.revision < 3) return;
  FrameCapabilities& c = rig.frame.declared.value();
  c.travel_step = Length::from_si(rig.plant.travel_resolution_m);
  c.force_step = Force::from_si(rig.plant.force_resolution_N);
  c.filter = Duration::zero();
  c.play = Length();
  c.force_class = ForceClass(rig.force_class_percent);
}

// Writes a specimen file whose confined stiffness is at least that of the specimen at twice the
// limit, and grows from there. M = 2 mu (1 - nu)/(1 - 2 nu) = E (1 - nu)/((1 + nu)(1 - 2 nu)).
void tell_specimen(Draw& draw, double true_N_m, RandomRig& rig) {
  const double diameter_m = draw.even(4e-3, 12e-3), margin = draw.scale(1.02, 8);
  const double nu = draw.chance(0.5) ? draw.even(0.2, 0.45) : draw.even(0.45, 0.495);
  const int layers = 1 + static_cast<int>(draw.even(0, 3));
  const bool is_known = draw.chance(0.88), is_rigid = draw.chance(0.07);
  const double strain = draw.scale(0.002, 0.15);  // at twice the limit, with the true stiffness
  rig.probe_diameter_m = round_to(draw.even(2e-3, 8e-3), 2);
  if (!is_known) return;
  const double area_m2 = std::numbers::pi / 4 * diameter_m * diameter_m;
  constexpr double kThickest_m = 0.1;
  const double thick_m = 2 * rig.limit_N / true_N_m / strain * draw.even(1, 2);
  const double thickness_m = std::clamp(thick_m, 2e-6, kThickest_m);
  const double modulus_Pa = margin * true_N_m * thickness_m / area_m2;
  const double youngs_Pa = modulus_Pa * (1 + nu) * (1 - 2 * nu) / (1 - nu);
  json material{{"relative_permittivity", 3}};
  if (is_rigid) {
    material["rigid"] = true;
  } else {
    material["youngs_modulus_kPa"] = youngs_Pa * 1e-3;
    material["poisson_ratio"] = nu;
  }
  const json layer{{"material", "m"}, {"thickness_mm", thickness_m * 1e3 / layers}};
  json stack = json::array();
  for (int i = 0; i < layers; ++i) stack.push_back(layer);
  const json specimen{{"format", "specimen/1"},
                      {"name", "random"},
                      {"disc_diameter_mm", diameter_m * 1e3},
                      {"faces", "free"},
                      {"materials", {{"m", material}}},
                      {"capacitors", json::array({{{"layers", stack}}})}};
  rig.specimen_text = specimen.dump();
}

std::uint32_t draw_quirks(Draw& draw) {
  constexpr double kHowOften[] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.3, 0.3, 0.8, 0.7, 0.9, 0.25, 0.4};
  std::uint32_t quirks = 0, bit = 1;
  for (const double p : kHowOften) {
    if (draw.chance(p)) quirks |= bit;
    bit <<= 1U;
  }
  return quirks;
}

}  // namespace

double CurvedSpecimen::shortening_m(double force_N) const {
  if (curvature_1_m_ <= 0) return force_N / stiffness_N_m_;
  // The root of c x^2 + x = F/k, in the form without cancellation.
  const double way = force_N / stiffness_N_m_;
  return 2 * way / (1 + std::sqrt(1 + 4 * curvature_1_m_ * way));
}

double CurvedSpecimen::stiffness_N_m(double force_N) const {
  return stiffness_N_m_ * std::sqrt(1 + 4 * curvature_1_m_ * force_N / stiffness_N_m_);
}

double CurvedSpecimen::capacitance_F(double force_N) const {
  constexpr double kFull_m = 1e-3;
  const double pressed = shortening_m(force_N) / kFull_m;
  return kUnloaded_F * (1 + pressed / (1 + pressed));
}

double RandomRig::stiffness_N_m(double force_N) const {
  return 1 / (1 / specimen().stiffness_N_m(force_N) + 1 / plant.frame_stiffness_N_m);
}

// Everything is drawn in a fixed order, even values that are not used afterwards. Leaving a quirk
// out then does not change the others.
RandomRig random_rig(std::uint64_t seed, const RigOptions& options) {
  Draw draw(seed);
  RandomRig rig;
  rig.seed = seed;
  rig.quirks = draw_quirks(draw) & ~options.without;
  draw_cell(draw, options, rig);
  draw_travel(draw, rig.quirks, rig);
  draw_stop(draw, rig.quirks, rig);
  draw_loop(draw, rig.quirks, rig);
  draw_link(draw, rig.quirks, rig);
  tell_capabilities(draw, rig);
  tell_steps(rig);
  const Contact contact = draw_contact(draw, rig.limit_N, (rig.quirks & kCurved) != 0);
  const CurvedSpecimen honest(contact.specimen_N_m, contact.curvature_1_m);
  tell_specimen(draw, honest.stiffness_N_m(2 * rig.limit_N), rig);
  const double stated_N_m = round_to(contact.frame_N_m * draw.scale(1.01, 2.5), 4);
  if (draw.chance(0.7)) rig.frame_stiffness_N_m = stated_N_m;

  rig.lie = options.lie.value_or(Lie());
  PlantConfig& p = rig.plant;
  // A factor on the stiffness at every force is a factor on both k and c.
  rig.specimen_N_m = contact.specimen_N_m * rig.lie.stiffness;
  rig.curvature_1_m = contact.curvature_1_m * rig.lie.stiffness;
  p.frame_stiffness_N_m = contact.frame_N_m * rig.lie.stiffness;
  p.drive_lag_s *= rig.lie.reaction;
  rig.gap_m = options.gap_m.value_or(rig.gap_m);
  p.start_travel_m = p.contact_travel_m - rig.gap_m;
  p.seed = seed;
  rig.frame.seed = seed;
  return rig;
}

Lie random_lie(std::uint64_t seed) {
  Draw draw(seed);
  const double stiffness = draw.scale(1.5, 20), reaction = draw.scale(1.5, 20);
  const bool both = draw.chance(0.2), stiff = draw.chance(0.5);
  Lie lie;
  if (both || stiff) lie.stiffness = stiffness;
  if (both || !stiff) lie.reaction = reaction;
  return lie;
}

Result<RandomRig> parse_rig(std::string_view text) {
  constexpr std::string_view kPrefix = "random:";
  const bool random = text.starts_with(kPrefix);
  const auto seed = number_from<std::uint64_t>(random ? text.substr(kPrefix.size()) : "");
  if (seed) return random_rig(*seed);
  return fail(Errc::invalid_request, "no rig `{}`, expected random:SEED, such as random:7", text);
}

std::string told_json(const RandomRig& rig) {
  json frame{{"force_class", rig.force_class_percent}};
  if (rig.frame_stiffness_N_m) frame["stiffness_N_mm"] = *rig.frame_stiffness_N_m * 1e-3;
  if (rig.force_loop) {
    const ForceLoop& l = *rig.force_loop;
    frame["force_loop"] = {{"approach_mm_s", l.approach.si() * 1e3},
                           {"contact_N", l.contact.si()},
                           {"rate_max_N_s", l.rate_max.si()},
                           {"lag_s", to_seconds(l.lag)},
                           {"ripple_N", l.ripple.si()},
                           {"stiffness_max_N_mm", l.stiffness_max.si() * 1e-3}};
  }
  json out{{"frame", frame}, {"fixture", {{"probe_diameter_mm", rig.probe_diameter_m * 1e3}}}};
  out["specimen"] = rig.specimen_text.empty() ? json() : json::parse(rig.specimen_text);
  return out.dump();
}

std::string describe(const RandomRig& rig) {
  const PlantConfig& p = rig.plant;
  const FrameCapabilities& c = *rig.frame.declared;
  return fmt::format(
      "rig random:{} quirks {:#x}: contact {:.4g} N/mm at 0 N, {:.4g} N/mm at {:.4g} N (frame "
      "{:.4g}, stated {}); reaction {:.3g} ms (told {:.3g}), deceleration {:.3g} mm/s2 (told "
      "{:.3g}); cell {:.3g} N, noise {:.2g} N, offset {:.2g} N; contact at {:.4f} mm of {:.4f} to "
      "{:.4f} mm, gap {:.4f} mm; {} Hz; revision {}; {}; specimen {}{}",
      rig.seed, rig.quirks, rig.stiffness_N_m(0) * 1e-3, rig.stiffness_N_m(rig.limit_N) * 1e-3,
      rig.limit_N, p.frame_stiffness_N_m * 1e-3,
      rig.frame_stiffness_N_m ? fmt::format("{:.4g}", *rig.frame_stiffness_N_m * 1e-3) : "nothing",
      rig.reaction_s() * 1e3, to_seconds(c.reaction) * 1e3, p.deceleration_m_s2 * 1e3,
      c.deceleration.si() * 1e3, p.force_nominal_N, p.force_noise_N, p.force_offset_N,
      p.contact_travel_m * 1e3, p.travel_min_m * 1e3, p.travel_max_m * 1e3, rig.gap_m * 1e3,
      rig.frame.rate_max_Hz, rig.frame.revision, c.force_hold ? "force loop" : "no force loop",
      rig.specimen_text.empty() ? "unknown" : rig.specimen_text,
      rig.lie.is_one() ? fmt::format("; it lies: stiffness x {:.3g}, reaction x {:.3g}",
                                     rig.lie.stiffness, rig.lie.reaction)
                       : "");
}

}  // namespace lcrig::sim
