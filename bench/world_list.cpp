// SPDX-License-Identifier: Apache-2.0
// The worlds of the table in docs/analysis.md.
#include "bench/worlds.hpp"

#include <fmt/format.h>

namespace lcrig::worlds {

namespace {

template <class Change>
World changed(const char* name, Change change) {
  World w;
  w.name = name;
  change(w);
  return w;
}

}  // namespace

std::vector<World> static_worlds() {
  return {
      changed("white", [](World&) {}),
      changed("AR(1) 0.8", [](World& w) { w.ar1 = 0.8; }),
      changed("noise grows with load", [](World& w) { w.noise_per_kPa = 0.05; }),
      changed("C0 moves per repeat", [](World& w) { w.offset_sd_fF = 20; }),
      changed("outliers 2 %", [](World& w) { w.outlier_share = 0.02; }),
      changed("slope +-1 % per repeat", [](World& w) { w.slope_sd = 0.01; }),
      changed("slope +-2 % per repeat", [](World& w) { w.slope_sd = 0.02; }),
      changed("slope +-5 % per repeat", [](World& w) { w.slope_sd = 0.05; }),
      changed("random walk", [](World& w) { w.walk_fF_sqrt_s = 0.1; }),
      changed("1/f", [](World& w) { w.flicker_fF = 0.3; }),
      changed("drift 50 fF/h", [](World& w) { w.drift_fF_h = 50; }),
      changed("drift 500 fF/h", [](World& w) { w.drift_fF_h = 500; }),
      changed("hum", [](World& w) { w.hum_fF = 0.5; }),
      changed("scatter shared, 3 fF", [](World& w) { w.shared_sd_fF = 3; }),
      changed("gain +-0.05 %", [](World& w) { w.gain_limit = 5e-4; }),
      changed("force +-1 %", [](World& w) { w.force_limit = 0.01; }),
      changed("creep 2 %/decade", [](World& w) { w.creep_per_decade = 0.02; }),
      changed("hysteresis 3 %", [](World& w) { w.hysteresis = 0.03; }),
  };
}

std::vector<World> dynamic_worlds() {
  return {
      changed("white", [](World&) {}),
      changed("AR(1) 0.8", [](World& w) { w.ar1 = 0.8; }),
      changed("slope +-1 % per cycle", [](World& w) { w.slope_sd = 0.01; }),
      changed("slope +-5 % per cycle", [](World& w) { w.slope_sd = 0.05; }),
      changed("random walk", [](World& w) { w.walk_fF_sqrt_s = 0.1; }),
      changed("1/f", [](World& w) { w.flicker_fF = 0.3; }),
      changed("drift 500 fF/h", [](World& w) { w.drift_fF_h = 500; }),
      changed("hysteresis 3 %", [](World& w) { w.hysteresis = 0.03; }),
      changed("hysteresis 3 %, slope +-2 %",
              [](World& w) { w.hysteresis = 0.03, w.slope_sd = 0.02; }),
  };
}

std::vector<World> slow_worlds() {
  std::vector<World> out;
  for (const double fF : {0.03, 0.1, 1.0, 3.0}) {
    out.push_back(changed("1/f", [fF](World& w) { w.flicker_fF = fF; }));
    out.back().name += fmt::format(" {:g} fF", fF);
  }
  for (const double fF : {0.01, 0.03, 0.3, 1.0}) {
    out.push_back(changed("random walk", [fF](World& w) { w.walk_fF_sqrt_s = fF; }));
    out.back().name += fmt::format(" {:g} fF", fF);
  }
  out.push_back(changed("random walk and 1/f", [](World& w) {
    w.walk_fF_sqrt_s = 0.1, w.flicker_fF = 0.2, w.drift_fF_h = 50;
  }));
  return out;
}

// An LCR-6100 at 100 kHz and 1 V: 0.05 % basic accuracy, 5 fF of offset after an open correction. A
// class 1 cell with a zero within 5 mN. A probe turned to 20 um. The rest is as seen on real
// specimens.
World realistic_world() {
  return changed("everything at once", [](World& w) {
    w.gain_limit = 5e-4;
    w.offset_limit_fF = 5;
    w.force_limit = 0.01;
    w.diameter_limit_mm = 0.02;
    w.force_zero_limit_N = 0.005;
    w.slope_sd = 0.01;
    w.offset_sd_fF = 3;
    w.drift_fF_h = 50;
    w.walk_fF_sqrt_s = 0.03;
    w.flicker_fF = 0.1;
    w.hum_fF = 0.2;
    w.outlier_share = 0.002;
    w.creep_per_decade = 0.005;
    w.shared_sd_fF = 1;
  });
}

}  // namespace lcrig::worlds
