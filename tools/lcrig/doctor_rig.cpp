// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "base/doc_page.hpp"
#include "base/port_url.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* kMendConfig = "lcrig config check says what is wrong in it";

bool is_serial(const PortUrl& url) {
  return url.kind == PortKind::path || url.kind == PortKind::usb;
}
bool is_serial(const std::string& port) {
  const auto url = parse_port_url(port);
  return url && is_serial(*url);
}

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

// The USB device of a terminal is some folders above it.
bool is_usb_device(const fs::path& device, const PortUrl& url) {
  std::error_code unknown;
  for (auto at = fs::canonical(device, unknown); at.has_relative_path(); at = at.parent_path()) {
    if (!fs::exists(at / "idVendor", unknown)) continue;
    return first_line(at / "idVendor") == fmt::format("{:04x}", url.usb_vendor) &&
           first_line(at / "idProduct") == fmt::format("{:04x}", url.usb_product) &&
           (url.usb_serial.empty() || first_line(at / "serial") == url.usb_serial);
  }
  return false;
}

// "serial:2184:005f" -> "/dev/ttyUSB0". A path stays as it is. "": no such device is plugged in.
std::string node_of(const Machine& machine, const PortUrl& url) {
  if (url.kind == PortKind::path) return url.path;
  std::error_code unknown;
  for (const auto& tty : fs::directory_iterator(machine.root / "sys/class/tty", unknown)) {
    if (!is_usb_device(tty.path() / "device", url)) continue;
    return "/dev/" + tty.path().filename().string();
  }
  return "";
}

struct Holder {
  std::string program, process;  // "minicom", "123"
};
struct Holders {
  std::vector<Holder> all;
  bool all_seen = true;  // false: the open files of some processes cannot be seen
};

bool holds(const fs::path& process, const fs::path& node, bool& all_seen) {
  std::error_code failed;
  for (const auto& fd : fs::directory_iterator(process / "fd", failed)) {
    std::error_code gone;
    if (fs::read_symlink(fd.path(), gone) == node) return true;
  }
  if (failed == std::errc::permission_denied) all_seen = false;
  return false;
}

Holders holders_of(const Machine& machine, const fs::path& node) {
  Holders out;
  std::error_code unknown;
  for (const auto& process : fs::directory_iterator(machine.root / "proc", unknown)) {
    const auto pid = process.path().filename().string();
    if (!std::ranges::all_of(pid, is_digit)) continue;
    if (!holds(process.path(), node, out.all_seen)) continue;
    out.all.push_back({first_line(process.path() / "comm"), pid});
  }
  return out;
}

// Tells whether members of the service's groups may open the port.
Finding look_at_rights(const std::string& about, const fs::path& node, const struct ::stat& there) {
  const auto* const group = ::getgrgid(there.st_gid);
  const std::string name = group != nullptr ? group->gr_name : std::to_string(there.st_gid);
  const bool for_group = (there.st_mode & (S_IRGRP | S_IWGRP)) == (S_IRGRP | S_IWGRP);
  const auto words = fmt::format("{}: group {}, mode {:o}", printable(node.string()),
                                 printable(name), there.st_mode & 07777U);
  if (for_group && (name == "lcrig" || name == "dialout")) return {about, Health::ok, words};
  return {about, Health::warn, words + ": the service is in groups lcrig and dialout",
          "name the adapter in a udev rule (" + doc_page("lab-setup") + ", \"Ports\")"};
}

void look_at_port(const Machine& machine, const std::string& about, const std::string& port,
                  Findings& findings) {
  if (port.empty()) return;
  const auto url = parse_port_url(port);
  if (!url) {
    findings.emplace_back(about, Health::bad, url.error().what, kMendConfig);
    return;
  }
  if (!is_serial(*url)) {
    findings.emplace_back(
        about, Health::ok,
        fmt::format("{}: not opened; lcrig doctor --ask asks through the daemon", printable(port)));
    return;
  }
  const auto named = node_of(machine, *url);
  const auto path = machine.root / fs::path(named).relative_path();
  struct ::stat there{};
  if (named.empty() || ::stat(path.c_str(), &there) != 0) {
    findings.emplace_back(about, Health::bad,
                          fmt::format("{}: no such port is there", printable(port)),
                          "look at cable and power: sudo dmesg | tail");
    return;
  }
  findings.push_back(look_at_rights(about, named, there));
  std::error_code unknown;
  const auto holders = holders_of(machine, fs::canonical(path, unknown));
  for (const auto& holder : holders.all) {
    const bool ours = holder.program == "lcrigd";
    findings.emplace_back(about, ours ? Health::ok : Health::bad,
                          fmt::format("{}: {} (process {}) has it open", printable(named),
                                      printable(holder.program), holder.process),
                          ours ? "" : "end that program");
  }
  if (holders.all.empty()) {
    findings.emplace_back(about, Health::ok,
                          fmt::format("{}: nobody has it open{}", printable(named),
                                      holders.all_seen ? "" : " of those whom you may look at"));
  }
}

}  // namespace

std::optional<RigConfig> look_at_config(const std::string& file, Findings& findings) {
  if (::access(file.c_str(), R_OK) != 0) {
    const std::string why = std::strerror(errno);  // saved before another system call changes errno
    findings.emplace_back("config", Health::warn, fmt::format("{}: {}", printable(file), why),
                          doc_page("lab-setup") + ", \"Service\"; or --config FILE");
    return std::nullopt;
  }
  const auto plain = require_plain_file(file);
  auto document = plain ? load_json(file) : fail(plain.error());
  if (!document) {
    findings.emplace_back("config", Health::bad, printable(document.error().what), kMendConfig);
    return std::nullopt;
  }
  const JsonReader root(*document);
  root.expect_format("lcrigd-config/1");
  RigConfig out;
  out.file = file;
  for (auto [key, port] :
       {std::pair("meter", &out.meter_port), std::pair("frame", &out.frame_port)}) {
    const auto part = root.find(key);
    if (part && part->is_object()) *port = part->optional_string("port").value_or("");
  }
  out.wire_log_directory = root.optional_string("wire_log_directory").value_or("");
  if (auto read = root.result(); !read) {
    findings.emplace_back("config", Health::bad, printable(read.error().what), kMendConfig);
    return std::nullopt;
  }
  findings.emplace_back(
      "config", Health::ok,
      fmt::format("{}: readable; lcrig config check checks all of it", printable(file)));
  return out;
}

void look_at_ports(const Machine& machine, const RigConfig& config, Findings& findings) {
  look_at_port(machine, "meter's port", config.meter_port, findings);
  look_at_port(machine, "frame's port", config.frame_port, findings);
}

// A driver that is built into the kernel has a folder there, too.
void look_at_modules(const Machine& machine, const RigConfig& config, Findings& findings) {
  if (!is_serial(config.meter_port) && !is_serial(config.frame_port)) return;
  std::string missing;
  for (const char* driver : {"usbserial", "ftdi_sio", "cp210x", "ch341", "pl2303", "cdc_acm"}) {
    std::error_code unknown;
    if (fs::exists(machine.root / "sys/module" / driver, unknown)) continue;
    missing += fmt::format("{}{}", missing.empty() ? "" : " ", driver);
  }
  if (missing.empty()) {
    findings.emplace_back("kernel modules", Health::ok, "the USB serial drivers are loaded");
    return;
  }
  findings.emplace_back("kernel modules", Health::warn,
                        "not loaded: " + missing + "; the service sees no port of theirs",
                        "sudo systemctl restart systemd-modules-load, then restart lcrigd");
}

Finding look_at_group(const std::string& group) {
  const auto* const entry = ::getgrnam(group.c_str());
  if (entry == nullptr) {
    return {"group", Health::warn, fmt::format("there is no group {}", group),
            "sudo systemd-sysusers"};
  }
  std::array<gid_t, 1024> mine{};
  const int n = ::getgroups(static_cast<int>(mine.size()), mine.data());
  const auto end = mine.begin() + std::max(n, 0);
  if (::geteuid() == 0 || ::getegid() == entry->gr_gid ||
      std::find(mine.begin(), end, entry->gr_gid) != end) {
    return {"group", Health::ok, fmt::format("you may use what belongs to group {}", group)};
  }
  return {"group", Health::warn,
          fmt::format("you are not in group {}, or have not logged in since", group),
          fmt::format("sudo adduser $USER {}, log in again", group)};
}

void look_at_instruments(const DaemonStatus& status, Findings& findings) {
  for (const auto& i : status.instruments) {
    const auto* const about = i.which == Instrument::lcr ? "meter" : "frame";
    const auto identity = printable(i.identity, 200);
    switch (i.condition) {
      case InstrumentCondition::ready:
      case InstrumentCondition::in_use:
        findings.emplace_back(about, Health::ok,
                              identity.empty() ? "answers" : "answers: " + identity);
        break;
      case InstrumentCondition::unasked:
        findings.emplace_back(about, Health::ok, "not asked: " + printable(i.why, 200),
                              "lcrig doctor --ask");
        break;
      case InstrumentCondition::absent:
      case InstrumentCondition::fault:
        findings.emplace_back(about, Health::bad, printable(i.why, 500),
                              doc_page("troubleshooting") + "; then lcrig status --ask");
        break;
    }
  }
}

}  // namespace lcrig::cli
