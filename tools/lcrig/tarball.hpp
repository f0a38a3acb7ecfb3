// SPDX-License-Identifier: Apache-2.0
// Packs a folder with the system's `tar`, without a shell. Used by doctor_bundle.
#pragma once

#include <filesystem>
#include <string>

#include "tools/lcrig/exit_code.hpp"

namespace lcrig::cli {

// Writes the folder `name` of `parent` as .tar.gz to the descriptor `to`. The owners' names are
// left out. Failure: tar does not exist, or what it printed.
Outcome<void> pack_folder(const std::filesystem::path& parent, const std::string& name, int to);

}  // namespace lcrig::cli
