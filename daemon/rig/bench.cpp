// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/bench.hpp"

#include <fmt/format.h>
#include <numbers>

#include "base/name_rule.hpp"
#include "base/near_word.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

void read(const JsonReader& r, const char* stem, Dimension d, double& into,
          const Range& range = kNotNegative) {
  if (const auto v = r.optional_quantity(stem, d, range)) into = *v;
}

// The largest rate that was tried, twice that of usual table-top frames.
constexpr Range kFrameRates_Hz{0.1, 1000};

void read_frame(const JsonReader& r, Bench& b) {
  PlantConfig& p = b.plant;
  read(r, "contact_travel", Dimension::length, p.contact_travel_m, kAnyNumber);
  read(r, "stiffness", Dimension::stiffness, p.frame_stiffness_N_m, kPositive);
  read(r, "drive_lag", Dimension::time, p.drive_lag_s);
  read(r, "deceleration", Dimension::acceleration, p.deceleration_m_s2, kPositive);
  read(r, "force_noise", Dimension::force, p.force_noise_N);
  read(r, "force_resolution", Dimension::force, p.force_resolution_N);
  read(r, "force_offset", Dimension::force, p.force_offset_N, kAnyNumber);
  read(r, "force_nominal", Dimension::force, p.force_nominal_N, kPositive);
  p.force_class = parse_force_class(r);
  b.cell_serial = parse_name(r, "cell_serial");
  read(r, "travel_resolution", Dimension::length, p.travel_resolution_m);
  read(r, "travel_min", Dimension::length, p.travel_min_m, kAnyNumber);
  read(r, "travel_max", Dimension::length, p.travel_max_m, kAnyNumber);
  read(r, "speed_max", Dimension::speed, p.speed_max_m_s, kPositive);
  read(r, "rate_max", Dimension::frequency, b.frame_rate_max_Hz, kFrameRates_Hz);
  if (p.travel_min_m >= p.travel_max_m) r.refuse("travel_min is not below travel_max");
  r.no_other_keys();
}

void read_meter(const JsonReader& r, PlantConfig& p) {
  constexpr const char* kConversion[] = {"conversion_fast", "conversion_medium", "conversion_slow"};
  constexpr const char* kNoise[] = {"noise_fast", "noise_medium", "noise_slow"};
  for (std::size_t i = 0; i < 3; ++i) {
    read(r, kConversion[i], Dimension::time, p.conversion_s[i], kPositive);
    read(r, kNoise[i], Dimension::capacitance, p.capacitance_noise_F[i]);
  }
  read(r, "stray_capacitance", Dimension::capacitance, p.stray_capacitance_F);
  read(r, "thermal_drift", Dimension::capacitance_rate, p.thermal_drift_F_per_s, kAnyNumber);
  if (const auto d = r.optional_number("dissipation", kNotNegative)) p.dissipation = *d;
  r.no_other_keys();
}

}  // namespace

std::optional<double> Fixture::probe_area_m2() const {
  if (!probe_diameter_m) return std::nullopt;
  return std::numbers::pi / 4 * *probe_diameter_m * *probe_diameter_m;
}

std::optional<ForceClass> parse_force_class(const JsonReader& frame) {
  const auto key = frame.find("force_class");
  if (!key) return std::nullopt;
  const double percent = key->number();
  if (is_force_class(percent)) return ForceClass(percent);
  key->refuse(fmt::format("{:g}, expected {}", percent, kForceClassWords));
  return std::nullopt;
}

std::string parse_name(const JsonReader& object, const char* key) {
  const auto name = object.optional_string(key);
  if (name && name->empty()) object.at(key).refuse("an empty name, expected some text");
  return name.value_or("");
}

Fixture parse_fixture(const JsonReader& fixture) {
  Fixture f;
  f.probe_diameter_m = fixture.quantity("probe_diameter", Dimension::length, kPositive);
  read(fixture, "local_gravity", Dimension::acceleration, f.local_gravity_m_s2, Range{9.7, 9.9});
  f.stray_limit_F = fixture.optional_quantity("stray_limit", Dimension::capacitance, kNotNegative);
  f.probe_serial = parse_name(fixture, "probe_serial");
  f.probe_name = parse_name(fixture, "probe_name");
  fixture.no_other_keys();
  return f;
}

Result<Bench> parse_bench(std::string_view text, const std::string& name) {
  auto document = JsonDocument::parse(text, name);
  if (!document) return fail(document.error());
  const JsonReader root(*document);
  root.expect_format("bench/1");
  Bench b;
  b.text = std::string(text);
  b.name = root.string("name");
  if (const auto why = why_no_name(b.name); why && root.sound()) root.at("name").refuse(*why);
  if (root.has("description")) root.string("description");
  b.error_tolerance = root.number("error_tolerance", Range{1e-9, 0.5});
  b.fixture = parse_fixture(root.object("fixture"));
  read_frame(root.object("frame"), b);
  read_meter(root.object("meter"), b.plant);
  if (const auto s = root.optional_quantity("operator_reaction", Dimension::time, kNotNegative)) {
    b.operator_reaction = from_seconds(*s);
  }
  if (root.optional_boolean("realistic").value_or(false)) b.errors = ErrorScope::everything;
  root.no_other_keys();
  if (auto ok = root.result(); !ok) return fail(ok.error());
  return b;
}

Result<Bench> find_bench(const std::string& what) {
  if (names_a_file(what)) {
    auto text = read_text_file(what);
    if (!text) return fail(text.error());
    return parse_bench(*text, what);
  }
  std::vector<std::string> names;
  for (const ShippedBench& b : shipped_benches()) {
    if (b.name == what) return parse_bench(b.text, what);
    names.emplace_back(b.name);
  }
  const auto guess = or_comma(did_you_mean(what, names));
  return fail(Errc::invalid_request, "no bench `{}`{} shipped: {}; or give the path of a file",
              what, guess, fmt::join(names, ", "));
}

Result<Bench> bench_of(const BenchChoice& choice) {
  auto bench = choice.bench_text.empty() ? find_bench(choice.bench)
                                         : parse_bench(choice.bench_text, choice.bench);
  if (bench && choice.errors) bench->errors = choice.errors;
  if (bench) bench->rig_seed = choice.rig_seed;
  return bench;
}

}  // namespace lcrig
