// SPDX-License-Identifier: Apache-2.0
// Writes the folder of `lcrig doctor --bundle`: the files that a person needs who looks for a fault
// elsewhere.
#pragma once

#include <string>

#include "tools/lcrig/command.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

struct BundleParts {
  std::string findings_json, status_json;  // empty: not known
  std::string config_file, database;
  std::string wire_log_directory;
  bool with_data = false;  // a copy of the database, and the wire logs of runs
};

// Failure: `folder` is there already, or something cannot be written. What cannot be read is left
// out and told to the console.
Outcome<void> write_bundle(Console& console, const Machine& machine, const std::string& folder,
                           const BundleParts& parts);

}  // namespace lcrig::cli
