// SPDX-License-Identifier: Apache-2.0
// Finds protocols, specimens and benches by name, for every command that takes one and for
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

// Looked for in this order: $LCRIG_DATA/<kind>s, the source tree that this program was built in,
// the installed data directory. The first one wins.
class LibraryPath {
 public:
  explicit LibraryPath(const ProcessEnv& env);

  // `what` is a path (it has a '/', ends in .json, or such a file exists) or a name. Nothing when
  // no such name is known. Failure: the file cannot be read.
  Outcome<std::optional<LibraryFile>> find(LibraryKind kind, const std::string& what) const;
  // As `find`; an unknown name is a failure that lists the known ones, and `also` with them.
  Outcome<LibraryFile> get(LibraryKind kind, const std::string& what,
                           const std::vector<std::string>& also = {}) const;
  Failure unknown(LibraryKind kind, const std::string& what,
                  const std::vector<std::string>& also = {}) const;
  std::vector<LibraryFile> list(LibraryKind kind) const;  // by name, without their texts

 private:
  std::vector<std::filesystem::path> folders(LibraryKind kind) const;
  std::optional<std::filesystem::path> data_;  // $LCRIG_DATA
  std::filesystem::path source_;  // empty: not run from a build tree
  std::filesystem::path installed_;
};

// A specimen by name: a file, one that was added to the database, or one that ships. Checked: its
// text parses. The database is only read, and only when it exists.
Outcome<LibraryFile> find_specimen_text(const Context& context, const std::string& db_path,
                                        const std::string& what);

}  // namespace lcrig::cli
