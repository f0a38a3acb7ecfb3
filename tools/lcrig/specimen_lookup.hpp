// SPDX-License-Identifier: Apache-2.0
// Finds a specimen by name: a file, one that was added to the database, or one that ships. Every
// command that takes a specimen uses it.
#pragma once

#include <string>

#include "tools/lcrig/command.hpp"
#include "tools/lcrig/library_path.hpp"

namespace lcrig::cli {

// Checked: its text parses. The database is only read, and only when it exists.
Outcome<LibraryFile> find_specimen_text(const Context& context, const std::string& db_path,
                                        const std::string& what);

}  // namespace lcrig::cli
