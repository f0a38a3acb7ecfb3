// SPDX-License-Identifier: Apache-2.0
// Chooses the slowest conversion that fits, because slower conversions have less noise.
#include "protocols/plan/aperture.hpp"

#include <fmt/format.h>

#include <cmath>

#include "protocols/expand.hpp"

namespace lcrig {

namespace {

constexpr double kLoadedReadings = 15;  // fewer readings do not resolve the peak of a cycle

// The strictest demand on the time of one conversion, s, and how it was calculated.
struct Demand {
  double longest_s = 1e300;
  std::string why;
  bool unknown_motion = false;  // loads continuously, but the specimen is unknown
};

void tighten(Demand& d, double longest_s, std::string why) {
  if (longest_s >= d.longest_s) return;
  d.longest_s = longest_s;
  d.why = std::move(why);
}

void look_at(const Step& step, const Environment& env, const Rig& rig, int average, Demand& d) {
  const StepFacts facts = facts_of(step);
  if (const Readings* m = facts.measures) {
    const double count = env.get(m->count), within = env.get(m->within);
    if (within / count >= d.longest_s * average) return;
    tighten(d, within / count / average,
            fmt::format("{:.0f} readings in {:.4g} s ({}) need a conversion of at most {:.0f} ms",
                        count, within, step.id, std::floor(within / count * 1e3)));
  }
  if (facts.frame_use != FrameUse::Kind::cycle) return;
  const double force = target_force_N(*facts.aim, env, rig);
  if (force <= 0) return;
  const auto loaded = loaded_time_s(force, env.get(*facts.speed), rig);
  if (!loaded) {
    d.unknown_motion = true;
    return;
  }
  // Loading and unloading: the specimen is under load for twice the loading time.
  const double time = 2 * *loaded;
  if (time / kLoadedReadings >= d.longest_s * average) return;
  tighten(d, time / kLoadedReadings / average,
          fmt::format("{:.0f} readings in the loaded part of {:.3g} s ({}) need a conversion of at "
                      "most {:.0f} ms",
                      kLoadedReadings, time, step.id, std::floor(time / kLoadedReadings * 1e3)));
}

}  // namespace

std::optional<double> loaded_time_s(double force_N, double speed_m_s, const Rig& rig) {
  if (!rig.compression_m || force_N <= 0) return std::nullopt;
  return rig.compression_m(force_N) / speed_m_s;
}

ApertureChoice choose_aperture(const Protocol& protocol, const Environment& environment,
                               const Rig& rig) {
  ApertureChoice out;
  const LcrSettings& lcr = protocol.sample.lcr;
  out.aperture = lcr.aperture;
  if (!protocol.sample.aperture_auto) {
    out.note = fmt::format("{}, as the file says", to_string(lcr.aperture));
    return out;
  }
  Environment env = environment;
  Demand demand;
  StepCursor cursor(protocol.steps, env);
  const bool measures_while_moving = protocol.sample.lcr_continuous;
  bool measures = false;
  for (std::int64_t n = 0; n < kStepsMax; ++n) {
    const Step* step = cursor.next();
    if (!step) break;
    const StepFacts facts = facts_of(*step);
    measures = measures || facts.measures != nullptr;
    if (!facts.moves || measures_while_moving) look_at(*step, env, rig, lcr.average, demand);
  }
  if (demand.unknown_motion && !measures) {
    out.aperture = Aperture::fast;
    out.note = "fast: loads continuously, and no specimen is stated from which to compute";
    return out;
  }
  for (const Aperture a : {Aperture::slow, Aperture::medium, Aperture::fast}) {
    LcrSettings single = lcr;
    single.aperture = out.aperture = a;
    single.average = 1;
    const double takes = to_seconds(rig.lcr.conversion_time(single));
    if (takes > demand.longest_s && a != Aperture::fast) continue;
    out.note = demand.why.empty()
                   ? fmt::format("{}: nothing in the protocol asks for more speed", to_string(a))
                   : fmt::format("{}: {}; it takes {:.0f} ms", to_string(a), demand.why,
                                 takes * lcr.average * 1e3);
    break;
  }
  return out;
}

}  // namespace lcrig
