// SPDX-License-Identifier: Apache-2.0
// backup, restore.
#include <fmt/ostream.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "storage/backup.hpp"
#include "storage/writer_lock.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/follow_run.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

json report_json(const std::string& file, const CopyReport& r, double seconds) {
  json out{{"file", file},
           {"bytes", r.bytes},
           {"runs", r.runs},
           {"rows", r.rows},
           {"without_end", r.without_end},
           {"broken", json::array()},
           {"seconds", seconds}};
  for (const auto& b : r.broken) {
    out["broken"].push_back(json{{"run", b.run}, {"finding", b.finding}});
  }
  return out;
}

// A signal ends the copy, and no partial copy stays behind.
Result<CopyReport> copy_until_stopped(const std::string& from, const std::string& to,
                                      CopyOptions options) {
  StopSignals signals(true);
  options.goes_on = [&signals] { return signals.take() == 0; };
  return copy_database(from, to, std::move(options));
}

Outcome<ExitCode> tell(Context& context, const std::string& file, const CopyReport& report,
                       double seconds) {
  show(context, report_json(file, report, seconds), [&](std::ostream& out) {
    fmt::print(out, "{}: {:.1f} MB, {} runs, {} rows checked, in {:.1f} s\n", printable(file),
               static_cast<double>(report.bytes) / 1e6, report.runs, report.rows, seconds);
  });
  if (!report.without_end.empty()) {
    context.console.note(fmt::format(
        "without an end when it was copied: run {}; a daemon that gets this file closes "
        "it as interrupted",
        fmt::join(report.without_end, ", ")));
  }
  for (const auto& broken : report.broken) {
    context.console.note(
        fmt::format("run {} is not as it was recorded, here and in what was copied: {}", broken.run,
                    printable(broken.finding, kLongestWords)));
  }
  return report.broken.empty() ? kOk : kFailed;
}

Failure no_copy(const Error& error, std::string next) {
  Failure out(error, std::move(next));
  if (error.code == Errc::aborted) out.code = kInterrupted;
  return out;
}

Outcome<ExitCode> backup(Context& context, const std::string& file) {
  auto from = context.db_path();
  if (!from) return from.error();
  const MonoTime begin = context.clock.now();
  auto report = copy_until_stopped(*from, file, {});
  if (!report) return no_copy(report.error(), "lcrig backup --help");
  return tell(context, file, *report, to_seconds(context.clock.now() - begin));
}

constexpr OneWord kBackup{"backup",
                          "Copy the database, also during a run, and check the copy",
                          "lcrig backup /media/backup/lcrig-2026-01-31.db",
                          backup,
                          kFileWord,
                          "The copy; must not be there yet"};

class RestoreCommand final : public Command {
 public:
  RestoreCommand()
      : Command("restore", "Put a backup where no database is, and check both",
                "sudo -u lcrigd lcrig restore BACKUP --to /var/lib/lcrig/lcrig.db") {}
  void declare(ArgumentList& list) override {
    list.positional({"BACKUP", Proposes::file}, backup_, "The copy that `lcrig backup` made");
    list.option("--to", to_, kFileWord, "The database; must not be there yet", true);
  }

  Outcome<ExitCode> run(Context& context) override {
    std::error_code unknown;
    if (!std::filesystem::exists(backup_, unknown) && !unknown) {
      return Failure(kFailed, fmt::format("there is no backup {}", printable(backup_)),
                     "give the file that `lcrig backup` made");
    }
    const auto written = has_writer(to_);
    if (!written) return Failure(written.error(), "lcrig restore --help");
    if (*written) {
      return Failure(kFailed, fmt::format("{}: a daemon records into it", to_),
                     "stop it, and move away what is there: systemctl stop lcrigd");
    }
    const MonoTime begin = context.clock.now();
    CopyOptions options;
    options.check_original = true;
    auto report = copy_until_stopped(backup_, to_, std::move(options));
    if (!report) return no_copy(report.error(), "lcrig restore --help");
    tell_owner(context);
    return tell(context, to_, *report, to_seconds(context.clock.now() - begin));
  }

 private:
  // The service writes as the owner of the folder, so the file must belong to the same owner.
  void tell_owner(const Context& context) const {
    struct ::stat folder{};
    const auto path = std::filesystem::absolute(to_).parent_path();
    if (::stat(path.c_str(), &folder) != 0 || folder.st_uid == ::geteuid()) return;
    context.console.note(
        fmt::format("{} is yours, and its folder somebody else's: sudo chown "
                    "--reference={} {}",
                    to_, shell_quoted(path.string()), shell_quoted(to_)));
  }

  std::string backup_, to_;
};

}  // namespace

const CommandFactory kBackupCommand = make_command<OneWordCommand, kBackup>;
const CommandFactory kRestoreCommand = make_command<RestoreCommand>;

}  // namespace lcrig::cli
