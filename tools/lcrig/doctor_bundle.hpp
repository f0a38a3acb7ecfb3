// SPDX-License-Identifier: Apache-2.0
// Writes the file of `lcrig doctor --bundle`: what a person needs who looks for a fault elsewhere,
// as one .tar.gz.
#pragma once

#include <string>

#include "tools/lcrig/command.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

struct BundleParts {
  std::string findings_json, status_json;  // empty: not known
  std::string config_file, database;
  std::string wire_log_directory;
  // A copy of the database, the wire logs of runs, and the journal with its numbers.
  bool with_data = false;
};

// Only its owner may read it. Failure: `file` is there already, or something cannot be written;
// then nothing is left behind. What cannot be read is left out and told to the console.
Outcome<void> write_bundle(Console& console, const Machine& machine, const std::string& file,
                           const BundleParts& parts);

}  // namespace lcrig::cli
