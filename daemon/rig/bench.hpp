// SPDX-License-Identifier: Apache-2.0
// Reads the bench file `bench/1`: the simulated instruments, their mounting and the tolerated error
// of the scene. Used by the daemon, by rehearsals and by lcrig-sim. docs/bench-file.md describes
// it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/force_class.hpp"
#include "base/quantity.hpp"
#include "base/result.hpp"
#include "base/strict_json.hpp"
#include "base/time.hpp"
#include "model/bench_errors.hpp"

namespace lcrig {

// The part that transmits the force: pressure = force / area of the probe tip.
struct Fixture {
  std::optional<double> probe_diameter_m;  // absent: unknown, so there are no pressures
  double local_gravity_m_s2 = kStandardGravity_m_s2;
  // Which probe it is. Runs that state the same one share the error of its area. Empty: not stated.
  std::string probe_serial = {}, probe_name = {};
  std::optional<double> stray_limit_F;  // of leads and fixture, without an open correction
  std::optional<double> probe_area_m2() const;
};
// Reads the `fixture` object of a bench or config file.
Fixture parse_fixture(const JsonReader& fixture);
// Reads a serial number or name, which must not be empty. Without the key: empty.
std::string parse_name(const JsonReader& object, const char* key);
// Reads `force_class` of the `frame` object of a bench or config file. nullopt: it is not stated.
std::optional<ForceClass> parse_force_class(const JsonReader& frame);

struct Bench {
  std::string name, text;
  Fixture fixture;
  double error_tolerance = 1e-3;  // relative error of the change in capacitance
  std::string cell_serial;  // of its load cell; empty: not stated
  PlantConfig plant;
  double frame_rate_max_Hz = 500;  // highest sample rate of its gateway
  std::optional<ErrorScope> errors;  // drawn by the seed; absent: white noise only
  std::optional<std::uint64_t> rig_seed;  // for the lasting errors; absent: that of the others
  Duration operator_reaction = std::chrono::seconds(2);
};
Result<Bench> parse_bench(std::string_view text, const std::string& name);

// The benches that ship with the program, by name.
struct ShippedBench {
  std::string_view name, text;
};
const std::vector<ShippedBench>& shipped_benches();
// Finds a bench: a file (a path, or a name that ends in .json), or the name of a shipped one.
Result<Bench> find_bench(const std::string& what);

// A bench as a person chose it for a rehearsal or a plan.
struct BenchChoice {
  std::string bench = "paper";  // a name, or "replay:DIR"
  std::string bench_text;  // text of the bench file; empty: `bench` is a shipped one
  std::optional<std::uint64_t> seed;  // absent: the bench's own
  std::optional<ErrorScope> errors;  // absent: those of the bench file
  std::optional<std::uint64_t> rig_seed;  // for the lasting errors; absent: `seed`
};
// Errors: those of the bench file.
Result<Bench> bench_of(const BenchChoice& choice);

}  // namespace lcrig
