// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/doctor_bundle.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/program_version.hpp"
#include "base/strict_json.hpp"
#include "base/whole_file.hpp"
#include "base/wire_log_name.hpp"
#include "storage/backup.hpp"
#include "storage/database.hpp"
#include "tools/lcrig/output_file.hpp"
#include "tools/lcrig/tarball.hpp"
#include "tools/lcrig/without_values.hpp"

namespace lcrig::cli {

namespace fs = std::filesystem;

namespace {

std::string versions() {
  utsname kernel{};
  ::uname(&kernel);
  const auto release = read_text_file("/etc/os-release");
  return fmt::format("lcrig {}\nkernel {} {} {}\n\n{}", program_version(), kernel.sysname,
                     kernel.release, kernel.machine, release ? *release : "");
}

// The newest wire logs. Those of runs contain every measured value; those of looks do not.
std::vector<fs::path> newest_logs(const std::string& directory, bool of_runs) {
  constexpr std::size_t kMost = 4;
  std::vector<std::pair<fs::file_time_type, fs::path>> logs;
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(directory, unknown)) {
    const std::string name = entry.path().filename();
    if (!(of_runs ? is_wire_log(name) : is_wire_log_of_looks(name))) continue;
    logs.emplace_back(entry.last_write_time(unknown), entry.path());
  }
  std::ranges::sort(logs, std::greater());
  std::vector<fs::path> out;
  for (std::size_t i = 0; i < std::min(kMost, logs.size()); ++i) out.push_back(logs[i].second);
  return out;
}

// A folder that is removed with everything in it at the end.
class ScratchFolder {
 public:
  static Outcome<ScratchFolder> beside(const std::string& file) {
    std::string name = file + ".XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) {
      return Failure(kFailed, fmt::format("{}: {}", file, std::strerror(errno)), "");
    }
    return ScratchFolder(std::move(name));
  }
  ScratchFolder(ScratchFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  ~ScratchFolder() {
    std::error_code left;
    if (!path_.empty()) fs::remove_all(path_, left);
  }
  const std::string& path() const { return path_; }

 private:
  explicit ScratchFolder(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

constexpr const char* kMakeRoom = "df -h; free some space, or name a file on another disk";

// True if the database is readable. If copying failed nevertheless, the copy could not be written.
bool is_sound(const std::string& database) {
  const auto db = open_read_only(database);
  if (!db) return false;
  const auto words = db->first("PRAGMA quick_check(1)",
                               [](const Statement& row) { return std::string(row.text(0)); });
  return words && *words && **words == "ok";
}

class Bundle {
 public:
  Bundle(Console& console, fs::path folder) : console_(console), folder_(std::move(folder)) {}

  void text(const char* name, const std::string& text) {
    if (!text.empty() && done_) done_ = write_file((folder_ / name).string(), "", text);
  }
  void left_out(const std::string& what) { console_.note("left out: " + what); }
  void copy(const fs::path& file, const char* name) {
    if (file.empty()) return;
    std::error_code failed;
    fs::copy_file(file, folder_ / name, failed);
    if (!failed) return;
    const auto words = fmt::format("{}: {}", file.string(), failed.message());
    if (failed != std::errc::no_space_on_device) return left_out(words);
    if (done_) done_ = Failure(kFailed, words, kMakeRoom);
  }
  void copy_database_of(const std::string& database) {
    if (!done_) return;
    const auto copied = copy_database(database, (folder_ / "lcrig.db").string());
    if (copied) return;
    if (!is_sound(database)) return left_out(copied.error().what);
    done_ = Failure(kFailed, copied.error().what, kMakeRoom);
  }
  Outcome<void> result() && { return std::move(done_); }

 private:
  Console& console_;
  fs::path folder_;
  Outcome<void> done_;
};

Outcome<void> fill(Console& console, const Machine& machine, const fs::path& folder,
                   const BundleParts& parts) {
  Bundle bundle(console, folder);
  bundle.text("versions.txt", versions());
  bundle.text("doctor.json", parts.findings_json);
  bundle.text("status.json", parts.status_json);
  bundle.copy(parts.config_file, "lcrigd.json");
  const auto journal =
      machine.output({"journalctl", "-u", "lcrigd", "-n", "5000", "--no-pager", "-o", "short-iso"});
  if (journal) {
    bundle.text("journal.txt", parts.with_data ? *journal : journal_without_numbers(*journal));
  } else {
    bundle.left_out("the journal: systemd is not there, or you are not in group systemd-journal");
  }
  for (const auto& log : newest_logs(parts.wire_log_directory, parts.with_data)) {
    bundle.copy(log, log.filename().c_str());
  }
  if (parts.with_data && !parts.database.empty()) {
    bundle.copy_database_of(parts.database);
  }
  return std::move(bundle).result();
}

}  // namespace

Outcome<void> write_bundle(Console& console, const Machine& machine, const std::string& file,
                           const BundleParts& parts) {
  constexpr const char* kFolder = "doctor-bundle";
  std::error_code unknown;
  if (fs::exists(fs::symlink_status(file, unknown))) {
    return Failure(kFailed, fmt::format("{}: {}", file, std::strerror(EEXIST)),
                   "name a file that is not there yet");
  }
  auto packed = PartFile::create(file);
  if (!packed) return Failure(packed.error());
  ::fchmod(packed->fd(), 0600);
  auto scratch = ScratchFolder::beside(file);
  if (!scratch) return scratch.error();
  const fs::path folder = fs::path(scratch->path()) / kFolder;
  if (::mkdir(folder.c_str(), 0700) != 0) {
    return Failure(kFailed, fmt::format("{}: {}", file, std::strerror(errno)), "");
  }
  if (auto filled = fill(console, machine, folder, parts); !filled) return filled;
  if (auto done = pack_folder(scratch->path(), kFolder, packed->fd()); !done) {
    done.error().what = fmt::format("{}: {}", file, done.error().what);
    return done;
  }
  auto named = packed->put_new();
  if (!named) return Failure(named.error(), "name a file that is not there yet");
  return {};
}

}  // namespace lcrig::cli
