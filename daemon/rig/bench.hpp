// SPDX-License-Identifier: Apache-2.0
// Reads the bench file `bench/1`: the simulated instruments, their mounting and the error that the
// scene may have. Used by the daemon, by rehearsals and by lcrig-sim. docs/bench-file.md describes
// it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/quantity.hpp"
#include "base/result.hpp"
#include "base/strict_json.hpp"
#include "base/time.hpp"
#include "model/bench_errors.hpp"

namespace lcrig {

// The part that carries the force: pressure = force / area of the probe tip.
struct Fixture {
  std::optional<double> probe_diameter_m;  // absent: not known, there are no pressures
  double local_gravity_m_s2 = kStandardGravity_m_s2;
  std::optional<double> probe_area_m2() const;
};
// The `fixture` object of a bench or config file.
Fixture parse_fixture(const JsonReader& fixture);

struct Bench {
  std::string name, text;
  Fixture fixture;
  double error_tolerance = 1e-3;  // relative, of the change in capacitance
  PlantConfig plant;
  double frame_rate_max_Hz = 500;  // the fastest samples of its gateway
  std::optional<ErrorScope> errors;  // drawn from the seed; absent: white noise only
  std::optional<std::uint64_t> rig_seed;  // of the errors that last; absent: as the others
  Duration operator_reaction = std::chrono::seconds(2);
};
Result<Bench> parse_bench(std::string_view text, const std::string& name);

// The benches that ship with the program, by name.
struct ShippedBench {
  std::string_view name, text;
};
const std::vector<ShippedBench>& shipped_benches();
// A file (a path, or a name that ends in .json), or the name of a shipped bench.
Result<Bench> find_bench(const std::string& what);
// Reads the text of a file. If it is empty: a bench that ships with the program.
Result<Bench> bench_of(const std::string& name, const std::string& text);

}  // namespace lcrig
