// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/specimen_lookup.hpp"

#include <system_error>

#include "base/text.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/specimens.hpp"
#include "tools/lcrig/next_command.hpp"

namespace lcrig::cli {

namespace {

// Names of the database; `wanted` becomes the text of `what` when it is there.
Outcome<std::vector<std::string>> look_in_database(const std::string& db_path,
                                                   const std::string& what, LibraryFile& wanted) {
  std::vector<std::string> names;
  std::error_code ignored;
  if (!std::filesystem::exists(db_path, ignored)) return names;
  if (std::filesystem::file_size(db_path, ignored) == 0) return names;  // it becomes a database
  auto db = open_read_only(db_path);
  if (!db) return Failure(db.error(), "give another --db");
  auto stored = list_specimens(*db);
  if (!stored) return Failure(stored.error());
  for (const auto& specimen : *stored) {
    names.push_back(specimen.name);
    if (specimen.name != what) continue;
    wanted.name = specimen.name;
    wanted.text = specimen.text;
  }
  return names;
}

Outcome<LibraryFile> checked(LibraryFile file) {
  const auto source = file.path.empty() ? "specimen " + file.name : file.path.string();
  auto specimen = parse_specimen(file.text, source);
  if (specimen) return file;
  return Failure(specimen.error(),
                 "correct the file; `lcrig specimen show paper-1` "
                 "prints a good one");
}

}  // namespace

Outcome<LibraryFile> find_specimen_text(const Context& context, const std::string& db_path,
                                        const std::string& what) {
  const LibraryPath library(context.env);
  LibraryFile wanted;
  std::vector<std::string> names;
  if (!names_a_file(what)) {  // what was added under a name comes before what ships
    auto stored = look_in_database(db_path, what, wanted);
    if (!stored) return stored.error();
    if (!wanted.text.empty()) return checked(std::move(wanted));
    names = std::move(*stored);
  }
  auto found = library.find(LibraryKind::specimen, what);
  if (!found) return found.error();
  if (*found) return checked(std::move(**found));
  for (const auto& shipped : shipped_specimens()) {
    names.emplace_back(shipped.name);
    if (shipped.name != what) continue;
    wanted.name = what;
    wanted.text = shipped.text;
    return checked(std::move(wanted));
  }
  Failure unknown = library.unknown(LibraryKind::specimen, what, names);
  unknown.next =
      next_command(context.global, {"specimen", "list"}, "or give a path to a .json file");
  return unknown;
}

}  // namespace lcrig::cli
