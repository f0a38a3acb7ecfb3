// SPDX-License-Identifier: Apache-2.0
// Packs a folder with the system's `tar`; no shell is asked.
#pragma once

#include <filesystem>
#include <string>

#include "tools/lcrig/exit_code.hpp"

namespace lcrig::cli {

// The folder `name` of `parent` as .tar.gz, to the descriptor `to`. The owners' names are left out.
// Failure: tar is not there, or what it said.
Outcome<void> pack_folder(const std::filesystem::path& parent, const std::string& name, int to);

}  // namespace lcrig::cli
