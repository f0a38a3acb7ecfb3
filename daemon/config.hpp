// SPDX-License-Identifier: Apache-2.0
// Reads the daemon's config file `lcrigd-config/1`; see docs/config-file.md and
// schema/config.schema.json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/rig/bench.hpp"
#include "drivers/load_frame.hpp"
#include "drivers/registry.hpp"
#include "drivers/stated_frame.hpp"

namespace lcrig {

enum class FrameDriver { zwick, dead_weight };
template <>
inline constexpr EnumWords<2> kWordsOf<FrameDriver>{"zwick", "dead_weight"};

// Facts about a frame that a person must state, because its gateway does not report them.
struct FrameFacts {
  std::optional<double> stiffness_N_m;  // of frame, cell and fixture together, at most; absent:
                                        // rigid
  std::optional<double> start_gap_m;  // the gap when a run begins
  std::string cell_serial;  // of the load cell; empty: not stated
  StatedFrame stated;  // what CAPS may state, too
};

struct Config {
  std::string database = "/var/lib/lcrig/lcrig.db";
  std::string socket = "/run/lcrig/control.sock";
  std::string log_level = "info";
  std::string metrics_file;  // for node-exporter's textfile collector; empty: none
  // Real instruments.
  const MeterDriver* meter_driver = nullptr;  // from drivers/registry.hpp
  std::string meter_port;  // "serial:2184:005f"
  std::string meter_serial_number;  // required serial number; empty: any
  FrameDriver frame_driver = FrameDriver::zwick;
  std::string frame_port;  // "tcp://192.168.5.2:4710"; empty for dead weights
  FrameFacts frame;
  Fixture fixture;
  std::string wire_log_directory;  // folder for wire logs of all ports; empty: no logs
  // Or instead of them a simulated bench, in real time. Its fixture comes from the bench file.
  std::optional<std::string> bench;  // name or path
  // Where the settings come from.
  std::string file;
  std::vector<std::string> given;  // keys in the file: "database", "frame.stiffness_N_mm"
  std::vector<std::string> of_command_line;  // keys that the command line overrides
};

Result<Config> parse_config(std::string_view text, const std::string& name);
Result<Config> load_config(const std::string& path);

}  // namespace lcrig
