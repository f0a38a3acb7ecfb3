// SPDX-License-Identifier: Apache-2.0
// Property: an accepted configuration names either a bench or both instruments.
#include "daemon/config.hpp"

#include <cmath>

#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {

namespace {

void require_sound(const Config& c) {
  if (c.bench) return require(c.meter_driver == nullptr, "a bench beside a meter");
  require(c.meter_driver != nullptr && !c.meter_port.empty(), "neither bench nor meter");
  const auto area = c.fixture.probe_area_m2();
  require(!area || (std::isfinite(*area) && *area > 0), "a probe without an area");
  require(std::isfinite(c.fixture.local_gravity_m_s2), "a gravity that is no number");
}

}  // namespace

void read_config(std::string_view input) {
  const auto config = parse_config(input, "fuzz.json");
  if (config) {
    require_sound(*config);
  } else {
    require_good_message(config.error());
  }
  const auto bench = parse_bench(input, "fuzz.json");
  if (!bench) return require_good_message(bench.error());
  require(std::isfinite(bench->error_tolerance) && bench->error_tolerance > 0, "a bad tolerance");
}

}  // namespace lcrig::fuzz
