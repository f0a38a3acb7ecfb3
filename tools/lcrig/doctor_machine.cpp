// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <poll.h>
#include <sys/timex.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>

#include "base/doc_page.hpp"
#include "base/processor_ticks.hpp"
#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

namespace {

struct ClosePipe {
  void operator()(std::FILE* pipe) const { ::pclose(pipe); }
};

// A command that hangs is ended after ten seconds.
std::optional<std::string> output_of(const std::vector<std::string>& words) {
  std::string line = "timeout 10";
  for (const auto& word : words) line += " " + shell_quoted(word);
  std::unique_ptr<std::FILE, ClosePipe> pipe(::popen((line + " 2>/dev/null").c_str(), "re"));
  if (!pipe) return std::nullopt;
  std::string out;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 1; n > 0;) {
    n = std::fread(buffer.data(), 1, buffer.size(), pipe.get());
    out.append(buffer.data(), n);
  }
  if (::pclose(pipe.release()) != 0) return std::nullopt;
  return out;
}

std::optional<bool> kernel_clock() {
  timex state{};
  const int told = ::adjtimex(&state);
  if (told < 0) return std::nullopt;
  return told != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
}

// The value of a "KEY=value" line of `systemctl show`.
std::string property(const std::string& shown, const std::string& key) {
  std::istringstream lines(shown);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(key + "=")) return line.substr(key.size() + 1);
  }
  return "";
}

}  // namespace

const char* to_string(Health health) {
  constexpr const char* kWords[] = {"ok", "warn", "bad"};
  return kWords[static_cast<std::size_t>(health)];
}

Health worst_of(const Findings& findings) {
  Health worst = Health::ok;
  for (const auto& finding : findings) worst = std::max(worst, finding.health);
  return worst;
}

Machine real_machine() {
  return {.output = output_of, .clock_is_synchronised = kernel_clock};
}

Finding look_at_clock(const Machine& machine) {
  const auto synchronised = machine.clock_is_synchronised();
  if (!synchronised) {
    return {"clock", Health::warn, "the kernel does not say whether the clock is synchronised",
            "look by hand: timedatectl"};
  }
  if (*synchronised) return {"clock", Health::ok, "synchronised"};
  return {"clock", Health::warn,
          "not synchronised: when a run was made may be wrong (intervals are not)",
          "sudo timedatectl set-ntp true, or install chrony"};
}

// Steal time since the computer was started.
Finding look_at_steal(const Machine& machine) {
  const auto ticks = read_processor_ticks(machine.root / "proc/stat");
  if (!ticks || ticks->all <= 0) {
    return {"steal time", Health::warn, "/proc/stat does not tell it", "look by hand: vmstat 1"};
  }
  const double percent = 100 * ticks->steal / ticks->all;
  const auto words = fmt::format("{:.2f} % of the processors' time since the start", percent);
  constexpr double kWorthATelling = 0.1, kTooMuch = 5;
  if (percent < kWorthATelling) return {"steal time", Health::ok, words};
  return {"steal time", percent < kTooMuch ? Health::warn : Health::bad,
          words + " was taken away by the host of this virtual machine",
          "use a real computer for measurements"};
}

// How late this program is woken. The daemon is woken no better.
Finding look_at_lateness(const Clock& clock) {
  constexpr int kTimes = 50, kWait_ms = 10;
  Duration worst{};
  for (int i = 0; i < kTimes; ++i) {
    const MonoTime begin = clock.now();
    ::poll(nullptr, 0, kWait_ms);
    worst = std::max(worst, clock.now() - begin - std::chrono::milliseconds(kWait_ms));
  }
  const double worst_ms = to_seconds(worst) * 1e3;
  const auto words =
      fmt::format("{:.1f} ms at most, of {} waits of {} ms", worst_ms, kTimes, kWait_ms);
  constexpr double kTolerable_ms = 20, kTooLate_ms = 200;
  if (worst_ms < kTolerable_ms) return {"lateness", Health::ok, words};
  return {"lateness", worst_ms < kTooLate_ms ? Health::warn : Health::bad, words,
          "end what else runs on this computer"};
}

void look_at_service(const Machine& machine, Findings& findings) {
  std::error_code unknown;
  if (!std::filesystem::exists(machine.root / "run/systemd/system", unknown)) {
    findings.emplace_back("service", Health::ok,
                          "systemd does not run this computer: not looked at");
    return;
  }
  const auto shown = machine.output(
      {"systemctl", "show", "lcrigd", "-p", "LoadState,ActiveState,SubState,UnitFileState", "-p",
       "NRestarts,Result,ProtectSystem,PrivateNetwork,NoNewPrivileges"});
  if (!shown || property(*shown, "LoadState") != "loaded") {
    findings.emplace_back("service", Health::warn, "lcrigd is not installed as a service",
                          doc_page("lab-setup") + ", \"Service\"");
    return;
  }
  const auto state = property(*shown, "ActiveState");
  const auto words = fmt::format("{} ({}), {}, {} restarts by itself", printable(state),
                                 printable(property(*shown, "SubState")),
                                 printable(property(*shown, "UnitFileState")),
                                 printable(property(*shown, "NRestarts")));
  if (state != "active") {
    findings.emplace_back("service", Health::bad,
                          words + ": " + printable(property(*shown, "Result")),
                          "journalctl -u lcrigd -n 50, then sudo systemctl start lcrigd");
  } else if (property(*shown, "NRestarts") != "0") {
    findings.emplace_back("service", Health::warn, words, "journalctl -u lcrigd: why it ended");
  } else {
    findings.emplace_back("service", Health::ok, words);
  }
  const bool closed =
      property(*shown, "ProtectSystem") == "strict" && property(*shown, "NoNewPrivileges") == "yes";
  const bool network = property(*shown, "PrivateNetwork") != "yes";
  if (!closed) {
    findings.emplace_back("sandbox", Health::warn, "the unit does not have the shipped sandbox",
                          "systemctl cat lcrigd: a drop-in takes it away");
  } else {
    findings.emplace_back("sandbox", Health::ok, network ? "closed, with a network" : "closed");
  }
}

void look_at_memory(const Machine& machine, std::optional<int> daemon_pid, Findings& findings) {
  if (!daemon_pid) return;
  std::ifstream file(machine.root / "proc" / std::to_string(*daemon_pid) / "status");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("VmLck:")) continue;
    std::istringstream fields(line.substr(6));
    long kB = 0;
    fields >> kB;
    if (kB > 0) {
      findings.emplace_back("memory", Health::ok,
                            fmt::format("{} MB of lcrigd are locked", kB / 1024));
    } else {
      findings.emplace_back(
          "memory", Health::warn,
          "lcrigd is not locked in memory: when it is short a stop may wait for the disk",
          "LimitMEMLOCK=infinity in the unit, or ulimit -l unlimited");
    }
    return;
  }
}

}  // namespace lcrig::cli
