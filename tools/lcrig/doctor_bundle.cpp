// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/doctor_bundle.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/program_version.hpp"
#include "base/strict_json.hpp"
#include "storage/backup.hpp"
#include "tools/lcrig/output_file.hpp"

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

// The newest of them. Those of runs hold every measured value; those of looks do not.
std::vector<fs::path> newest_logs(const std::string& directory, bool of_runs) {
  constexpr std::size_t kMost = 4;
  std::vector<std::pair<fs::file_time_type, fs::path>> logs;
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(directory, unknown)) {
    const bool of_look = entry.path().filename().string().find("-looks-") != std::string::npos;
    if (entry.path().extension() != ".wire" || (!of_look && !of_runs)) continue;
    logs.emplace_back(entry.last_write_time(unknown), entry.path());
  }
  std::ranges::sort(logs, std::greater());
  std::vector<fs::path> out;
  for (std::size_t i = 0; i < std::min(kMost, logs.size()); ++i) out.push_back(logs[i].second);
  return out;
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
    if (failed) left_out(fmt::format("{}: {}", file.string(), failed.message()));
  }
  Outcome<void> result() && { return std::move(done_); }

 private:
  Console& console_;
  fs::path folder_;
  Outcome<void> done_;
};

}  // namespace

Outcome<void> write_bundle(Console& console, const Machine& machine, const std::string& folder,
                           const BundleParts& parts) {
  if (::mkdir(folder.c_str(), 0700) != 0) {
    return Failure(kFailed, fmt::format("{}: {}", folder, std::strerror(errno)),
                   "name a folder that is not there yet");
  }
  Bundle bundle(console, folder);
  bundle.text("versions.txt", versions());
  bundle.text("doctor.json", parts.findings_json);
  bundle.text("status.json", parts.status_json);
  bundle.copy(parts.config_file, "lcrigd.json");
  const auto journal =
      machine.output({"journalctl", "-u", "lcrigd", "-n", "5000", "--no-pager", "-o", "short-iso"});
  if (journal) {
    bundle.text("journal.txt", *journal);
  } else {
    bundle.left_out("the journal: systemd is not there, or you are not in group systemd-journal");
  }
  for (const auto& log : newest_logs(parts.wire_log_directory, parts.with_data)) {
    bundle.copy(log, log.filename().c_str());
  }
  if (parts.with_data && !parts.database.empty()) {
    const auto copied = copy_database(parts.database, (fs::path(folder) / "lcrig.db").string());
    if (!copied) bundle.left_out(copied.error().what);
  }
  return std::move(bundle).result();
}

}  // namespace lcrig::cli
