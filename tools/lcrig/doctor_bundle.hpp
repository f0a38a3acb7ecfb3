// SPDX-License-Identifier: Apache-2.0
// Writes the file of `lcrig doctor --bundle`, one .tar.gz: everything that somebody elsewhere needs
// to find a fault.
#pragma once

#include <string>

#include "tools/lcrig/command.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

struct BundleParts {
  std::string findings_json, status_json;  // empty: not known
  std::string config_file, database;
  std::string wire_log_directory;
  // Include a copy of the database, the wire logs of runs, and the journal with its numbers.
  bool with_data = false;
};

// Only the owner may read the file. Parts that cannot be read are left out, and the console says
// so. Failure: `file` exists already, or something cannot be written; nothing is left behind then.
Outcome<void> write_bundle(Console& console, const Machine& machine, const std::string& file,
                           const BundleParts& parts);

}  // namespace lcrig::cli
