// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/library_path.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <system_error>

#include "base/near_word.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/specimens.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/did_you_mean.hpp"

namespace lcrig::cli {

namespace fs = std::filesystem;

namespace {

struct KindRow {
  const char* noun;
  const char* folder;  // below $LCRIG_DATA and the installed data directory
  const char* source;  // in the source tree
  std::string_view format;  // how "format" begins in the file
  const char* list_command;
};

const KindRow& row_of(LibraryKind kind) {
  static constexpr KindRow kRows[] = {
      {"protocol", "protocols", "protocols/library", "load-protocol/", "lcrig protocol list"},
      {"specimen", "specimens", "model/library", "specimen/", "lcrig specimen list"},
      {"bench", "benches", "daemon/rig/benches", "bench/", "lcrig rehearse --help"},
  };
  return kRows[static_cast<std::size_t>(kind)];
}

ExitCode code_of(LibraryKind kind) {
  return kind == LibraryKind::protocol ? kProtocol : kFailed;
}

// A folder may hold files of several kinds, which "format" distinguishes.
bool has_format(const fs::path& path, std::string_view prefix) {
  auto document = load_json(path.string());
  if (!document) return true;  // a broken file is listed, and refused with the reason when used
  const JsonReader reader(*document);
  if (!reader.is_object() || !reader.has("format") || !reader.at("format").is_string()) return true;
  return reader.string("format").starts_with(prefix);
}

// True if "static-frame.json" was typed, no such file exists, and the library has that name.
bool is_shipped(const LibraryPath& library, LibraryKind kind, const fs::path& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored)) return false;
  return std::ranges::any_of(library.list(kind), [&](const LibraryFile& file) {
    return path == fs::path(file.name + ".json");
  });
}

// Loads a file. A specimen gives its own name, which runs and reports use. A broken file goes by
// its file name.
Outcome<LibraryFile> load(LibraryKind kind, const fs::path& path) {
  LibraryFile file;
  file.name = path.stem().string();
  file.path = path;
  auto text = read_text_file(path.string());
  if (!text) return Failure(text.error(), "check the path");
  file.text = std::move(*text);
  if (kind != LibraryKind::specimen) return file;
  if (const auto specimen = parse_specimen(file.text, path.string())) file.name = specimen->name;
  return file;
}

// The source tree of a build tree, which may be anywhere. Empty: `build` is not a build tree.
fs::path source_of(const fs::path& build) {
  constexpr std::string_view kKey = "CMAKE_HOME_DIRECTORY:INTERNAL=";
  std::ifstream cache(build / "CMakeCache.txt");
  for (std::string line; std::getline(cache, line);) {
    if (line.starts_with(kKey)) return line.substr(kKey.size());
  }
  return {};
}

// The names in the database. If `what` is among them, `wanted` gets its text.
Outcome<std::vector<std::string>> look_in_database(const std::string& db_path,
                                                   const std::string& what, LibraryFile& wanted) {
  std::vector<std::string> names;
  std::error_code ignored;
  if (!std::filesystem::exists(db_path, ignored)) return names;
  if (std::filesystem::file_size(db_path, ignored) == 0) return names;  // it may become a database
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
  // What is stored already is read under any name.
  auto specimen =
      file.path.empty() ? parse_specimen(file.text, source) : accept_specimen(file.text, source);
  if (specimen) return file;
  return Failure(specimen.error(),
                 "correct the file; `lcrig specimen show paper-1` "
                 "prints a good one");
}

}  // namespace

LibraryPath::LibraryPath(const ProcessEnv& env) {
  if (const auto data = env.get("LCRIG_DATA")) data_ = *data;
  const auto prefix = env.executable.parent_path().parent_path();  // of build/bin or /usr/bin
  source_ = source_of(prefix);
  installed_ = prefix / "share" / "lcrig";
}

std::vector<fs::path> LibraryPath::folders(LibraryKind kind) const {
  const auto& row = row_of(kind);
  std::vector<fs::path> out;
  if (data_) out.push_back(*data_ / row.folder);
  if (!source_.empty()) out.push_back(source_ / row.source);
  out.push_back(installed_ / row.folder);
  return out;
}

Outcome<std::optional<LibraryFile>> LibraryPath::find(LibraryKind kind,
                                                      const std::string& what) const {
  std::error_code ignored;
  if (names_a_file(what) || fs::is_regular_file(what, ignored)) {
    if (is_shipped(*this, kind, what)) {
      return Failure(code_of(kind),
                     fmt::format("there is no file {}; the {} that ships is called {}", what,
                                 row_of(kind).noun, fs::path(what).stem().string()),
                     row_of(kind).list_command);
    }
    auto file = load(kind, what);
    if (!file) return file.error();
    return std::optional<LibraryFile>(std::move(*file));
  }
  for (const auto& folder : folders(kind)) {
    const auto path = folder / (what + ".json");
    if (!fs::is_regular_file(path, ignored) || !has_format(path, row_of(kind).format)) continue;
    auto file = load(kind, path);
    if (!file) return file.error();
    return std::optional<LibraryFile>(std::move(*file));
  }
  return std::optional<LibraryFile>();
}

Failure LibraryPath::unknown(LibraryKind kind, const std::string& what,
                             const std::vector<std::string>& also) const {
  const auto& row = row_of(kind);
  std::vector<std::string> names = also;
  for (const auto& file : list(kind)) names.push_back(file.name);
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  const auto none =
      fmt::format("none is installed; LCRIG_DATA may name a folder that holds {}/", row.folder);
  const auto known = names.empty() ? none : "known: " + join_words(names);
  return Failure(code_of(kind),
                 fmt::format("no {} is called '{}'{} ({})", row.noun, what,
                             did_you_mean(what, names, kGuessAtPrompt), known),
                 fmt::format("{}   (or give a path to a .json file)", row.list_command));
}

Outcome<LibraryFile> LibraryPath::get(LibraryKind kind, const std::string& what,
                                      const std::vector<std::string>& also) const {
  auto found = find(kind, what);
  if (!found) return found.error();
  if (*found) return std::move(**found);
  return unknown(kind, what, also);
}

std::vector<LibraryFile> LibraryPath::list(LibraryKind kind) const {
  std::map<std::string, LibraryFile> by_name;
  for (const auto& folder : folders(kind)) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.path().extension() != ".json") continue;
      if (!has_format(entry.path(), row_of(kind).format)) continue;
      LibraryFile file;
      file.name = entry.path().stem().string();
      file.path = entry.path();
      by_name.emplace(file.name, std::move(file));
    }
  }
  std::vector<LibraryFile> out;
  out.reserve(by_name.size());
  for (auto& [name, file] : by_name) out.push_back(std::move(file));
  return out;
}

Outcome<LibraryFile> find_specimen_text(const Context& context, const std::string& db_path,
                                        const std::string& what) {
  const LibraryPath library(context.env);
  LibraryFile wanted;
  std::vector<std::string> names;
  if (!names_a_file(what)) {  // an added specimen takes precedence over one that ships
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
