// SPDX-License-Identifier: Apache-2.0
// Finds protocols, specimens and benches by name. Used by every command that takes one, and by
// completion.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/lcrig/exit_code.hpp"
#include "tools/lcrig/process_env.hpp"

namespace lcrig::cli {

struct Context;  // tools/lcrig/command.hpp

enum class LibraryKind { protocol, specimen, bench };

struct LibraryFile {
  std::string name;  // "static-frame"
  std::filesystem::path path;
  std::string text;
};

// Looks in these places, and the first match wins: $LCRIG_DATA/<kind>s, the source tree in which
// this program was built, the installed data directory.
class LibraryPath {
 public:
  explicit LibraryPath(const ProcessEnv& env);

  // `what` is a path (it has a '/', ends in .json, or such a file exists) or a name. Empty: the
  // name is not known. Failure: the file cannot be read.
  Outcome<std::optional<LibraryFile>> find(LibraryKind kind, const std::string& what) const;
  // As `find`, but an unknown name is a failure that lists the known names and `also`.
  Outcome<LibraryFile> get(LibraryKind kind, const std::string& what,
                           const std::vector<std::string>& also = {}) const;
  Failure unknown(LibraryKind kind, const std::string& what,
                  const std::vector<std::string>& also = {}) const;
  std::vector<LibraryFile> list(LibraryKind kind) const;  // sorted by name; without texts

 private:
  std::vector<std::filesystem::path> folders(LibraryKind kind) const;
  std::optional<std::filesystem::path> data_;  // $LCRIG_DATA
  std::filesystem::path source_;  // empty: the program does not run from a build tree
  std::filesystem::path installed_;
};

// Finds a specimen by name: a file, one that was added to the database, or one that ships. Its text
// has been checked to parse. The database is only read, and only if it exists.
Outcome<LibraryFile> find_specimen_text(const Context& context, const std::string& db_path,
                                        const std::string& what);

}  // namespace lcrig::cli
