// SPDX-License-Identifier: Apache-2.0
#include "daemon/config.hpp"

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/log.hpp"
#include "base/port_url.hpp"
#include "daemon/rig/bench.hpp"

namespace lcrig {

namespace {

std::string read_port(const JsonReader& r) {
  std::string port = r.string("port");
  if (port.empty()) {
    r.at("port").refuse("an empty port, expected for example \"serial:2184:005f\"");
  } else if (const auto url = parse_port_url(port); !url) {
    r.at("port").refuse(url.error().what);
  }
  return port;
}

void read_meter(const JsonReader& r, Config& c) {
  std::vector<std::pair<std::string_view, const MeterDriver*>> drivers;
  drivers.reserve(std::size(kMeterDrivers));
  for (const MeterDriver& driver : kMeterDrivers) drivers.emplace_back(driver.name, &driver);
  c.meter_driver = r.word<const MeterDriver*>("driver", drivers);
  c.meter_port = read_port(r);
  c.meter_serial_number = r.optional_string("serial_number").value_or("");
  r.no_other_keys();
}

ForceLoop read_force_loop(const JsonReader& r) {
  ForceLoop loop;
  loop.approach = Velocity::from_si(r.quantity("approach", Dimension::speed, kPositive));
  loop.contact = Force::from_si(r.quantity("contact", Dimension::force, kPositive));
  loop.rate_max = ForceRate::from_si(r.quantity("rate_max", Dimension::force_rate, kPositive));
  loop.lag = from_seconds(r.quantity("lag", Dimension::time, Range{0, 60}));
  loop.ripple = Force::from_si(r.quantity("ripple", Dimension::force, kNotNegative));
  loop.stiffness_max =
      Stiffness::from_si(r.quantity("stiffness_max", Dimension::stiffness, kPositive));
  r.no_other_keys();
  return loop;
}

template <class T>
void read_optional(const JsonReader& r, std::string_view stem, Dimension d, const Range& range,
                   T (*make)(double), std::optional<T>& out) {
  if (const auto si = r.optional_quantity(stem, d, range)) out = make(*si);
}

void read_stated(const JsonReader& r, StatedFrame& s) {
  s.force_class = parse_force_class(r);
  if (const auto loop = r.find("force_loop")) s.force_loop = read_force_loop(*loop);
  read_optional<Length>(r, "travel_step", Dimension::length, kNotNegative, Length::from_si,
                        s.travel_step);
  read_optional<Force>(r, "force_step", Dimension::force, kNotNegative, Force::from_si,
                       s.force_step);
  read_optional<Duration>(r, "filter", Dimension::time, Range{0, 60}, from_seconds, s.filter);
  read_optional<Length>(r, "play", Dimension::length, kNotNegative, Length::from_si, s.play);
}

void read_frame(const JsonReader& r, Config& c) {
  const JsonReader driver = r.at("driver");
  c.frame_driver = driver.word<FrameDriver>();
  if (!driver.sound()) return;  // the keys of an unknown driver are unknown, too
  if (c.frame_driver == FrameDriver::zwick) {
    FrameFacts& f = c.frame;
    c.frame_port = read_port(r);
    f.stiffness_N_m = r.optional_quantity("stiffness", Dimension::stiffness, kPositive);
    f.start_gap_m = r.optional_quantity("start_gap", Dimension::length, Range{0, 1});
    read_stated(r, f.stated);
    f.cell_serial = parse_name(r, "cell_serial");
  }
  r.no_other_keys();
}

// True for the name of a shipped bench. Files and recordings (replay:DIR) are checked when the
// daemon starts.
bool is_bench_name(const std::string& bench) {
  return bench.find_first_of("/:") == bench.npos && !bench.ends_with(".json");
}

void read_rig(const JsonReader& root, Config& c) {
  if (root.has("bench")) {
    c.bench = root.string("bench");
    if (is_bench_name(*c.bench)) {
      if (auto bench = find_bench(*c.bench); !bench) root.at("bench").refuse(bench.error().what);
    }
    if (root.has("meter") || root.has("frame")) {
      root.at("bench").refuse_key(
          "`bench` beside `meter` or `frame`, expected the simulated bench or instruments");
    }
    return;
  }
  read_meter(root.object("meter"), c);
  read_frame(root.object("frame"), c);
  c.fixture = parse_fixture(root.object("fixture"));
  if (auto v = root.optional_string("wire_log_directory")) c.wire_log_directory = *v;
}

void read_path(const JsonReader& root, const char* key, std::string& out) {
  const auto path = root.optional_string(key);
  if (!path) return;
  if (path->empty() || path->find('\0') != path->npos) {
    root.at(key).refuse("no file can have this name; expected a path");
  }
  out = *path;
}

void add_keys(const nlohmann::json& object, const std::string& before,
              std::vector<std::string>& out) {
  for (const auto& [key, value] : object.items()) {
    if (value.is_object()) {
      add_keys(value, before + key + ".", out);
    } else {
      out.push_back(before + key);
    }
  }
}

}  // namespace

Result<Config> parse_config(std::string_view text, const std::string& name) {
  auto document = JsonDocument::parse(text, name);
  if (!document) return fail(document.error());
  const JsonReader root(*document);
  root.expect_format("lcrigd-config/1");
  Config c;
  read_path(root, "database", c.database);
  read_path(root, "socket", c.socket);
  read_path(root, "metrics_file", c.metrics_file);
  if (root.has("log_level")) {
    std::vector<std::pair<std::string_view, std::string_view>> levels;
    for (const auto level : kLogLevels) levels.emplace_back(level, level);
    c.log_level = root.word<std::string_view>("log_level", levels);
  }
  read_rig(root, c);
  root.no_other_keys();
  if (auto ok = root.result(); !ok) return fail(ok.error());
  c.file = name;
  add_keys(document->root(), "", c.given);
  return c;
}

Result<Config> load_config(const std::string& path) {
  if (auto plain = require_plain_file(path); !plain) return fail(plain.error());
  auto text = read_text_file(path);
  if (!text) return fail(text.error());
  return parse_config(*text, path);
}

}  // namespace lcrig
