// SPDX-License-Identifier: Apache-2.0
#include "daemon/config_check.hpp"

#include <sys/un.h>

#include <filesystem>
#include <system_error>

#include "base/strict_json.hpp"
#include "daemon/config_keys.hpp"
#include "daemon/metrics.hpp"
#include "daemon/rig/recording.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"

namespace lcrig {

namespace {

namespace fs = std::filesystem;

bool is_folder(const fs::path& path) {
  std::error_code ec;
  return fs::is_directory(path, ec);
}

// systemd creates the default folders (StateDirectory, RuntimeDirectory) when the service starts.
Result<> check_folder(const std::string& file, const char* key, const std::string& path,
                      const std::string& made_by_systemd) {
  std::error_code unknown;
  const fs::path folder = fs::absolute(path, unknown).parent_path();
  if (is_folder(folder) || path == made_by_systemd) return {};
  return fail(Errc::invalid_request,
              "{}: `{}` is {}, but there is no folder {}; make it, or correct `{}`", file, key,
              path, folder.string(), key);
}

Result<> check_bench(const Config& config, const std::string& file) {
  if (!config.bench) return {};
  Result<> good;
  if (const auto directory = replay_directory(*config.bench)) {
    auto recording = load_recording(*directory);
    if (!recording) good = fail(recording.error());
  } else if (auto bench = find_bench(*config.bench); !bench) {
    good = fail(bench.error());
  }
  if (good) return good;
  Error error = good.error();
  error.what = fmt::format("{}: `bench`: {}", file, error.what);
  return fail(std::move(error));
}

Result<> check_socket(const Config& config, const std::string& file) {
  constexpr std::size_t kMost = sizeof(sockaddr_un::sun_path) - 1;
  if (config.socket.size() > kMost) {
    return fail(Errc::invalid_request,
                "{}: `socket` is {} characters long, but a socket's path has at most {}; choose a "
                "shorter one",
                file, config.socket.size(), kMost);
  }
  std::error_code unknown;
  const auto there = fs::symlink_status(config.socket, unknown);
  if (fs::exists(there) && !fs::is_socket(there)) {
    return fail(Errc::invalid_request,
                "{}: `socket` is {}, which exists and is no socket; move it away or correct "
                "`socket`",
                file, config.socket);
  }
  return check_folder(file, "socket", config.socket, Config().socket);
}

Result<> check_database(const Config& config, const std::string& file) {
  if (is_folder(config.database)) {
    return fail(Errc::invalid_request,
                "{}: `database` is {}, which is a folder; name a file in it, such as {}", file,
                config.database, (fs::path(config.database) / "lcrig.db").string());
  }
  return check_folder(file, "database", config.database, Config().database);
}

fs::path place_of(const std::string& path) {
  std::error_code unknown;
  return fs::weakly_canonical(fs::absolute(path, unknown), unknown);
}

// Checks that the file may be replaced every 15 s, so it must not be a file with other content.
Result<> check_metrics_file(const Config& config, const std::string& file) {
  const std::string& path = config.metrics_file;
  if (path.empty()) return {};
  const auto refuse = [&](std::string_view why) {
    return fail(Errc::invalid_request, "{}: `metrics_file` is {}, {}", file, path, why);
  };
  std::vector<std::string> others{config.database, config.socket, file};
  for (const char* suffix : {"-wal", "-shm", ".lock", ".writer", ".reserve"}) {
    others.push_back(config.database + suffix);
  }
  for (const std::string& other : others) {
    if (place_of(path) == place_of(other)) {
      return refuse("which the daemon needs for something else");
    }
  }
  if (auto good = check_folder(file, "metrics_file", path, ""); !good) return good;
  std::error_code ec;
  const auto there = fs::symlink_status(path, ec);
  if (!fs::exists(there)) return {};
  if (!fs::is_regular_file(there)) return refuse("which is no plain file: name another one");
  const auto text = read_text_file(path);
  if (text && (text->empty() || text->starts_with(kMetricsBegin))) return {};
  return refuse("and holds something else, which would be replaced: name another file");
}

Result<> check_ports(const Config& config, const std::string& file) {
  if (config.meter_port.empty() || config.meter_port != config.frame_port) return {};
  return fail(
      Errc::invalid_request,
      "{}: `meter.port` and `frame.port` are both {}; each instrument has a port of its own", file,
      config.meter_port);
}

}  // namespace

Result<> check_surroundings(const Config& config, const std::string& file) {
  std::optional<Error> all;
  for (const auto check :
       {check_bench, check_database, check_socket, check_metrics_file, check_ports}) {
    const auto good = check(config, file);
    if (good) continue;
    if (!all) {
      all = good.error();
    } else {
      all->detail += (all->detail.empty() ? "" : "\n") + good.error().what;
    }
  }
  if (all) return fail(std::move(*all));
  return {};
}

std::vector<std::string> config_warnings(const Config& config, const std::string& file) {
  std::vector<std::string> out;
  const std::string &logs = config.wire_log_directory, &metrics = config.metrics_file;
  if (const auto safe = require_safe_to_create(config.database); !safe) {
    out.push_back(fmt::format("{}: `database`: {}", file, safe.error().what));
  }
  const auto folder = fs::path(config.database).parent_path();
  if (config.database == Config().database && !is_folder(folder)) {
    out.push_back(
        fmt::format("{}: there is no folder {} for `database`: systemd makes it when the service "
                    "starts; to start lcrigd by hand, make it, or name another file",
                    file, folder.string()));
  }
  if (!logs.empty() && !is_folder(logs)) {
    out.push_back(
        fmt::format("{}: `wire_log_directory` is {}, and there is no such folder: runs go "
                    "on without wire logs; make it, or correct `wire_log_directory`",
                    file, logs));
  }
  if (!metrics.empty() && !metrics.ends_with(".prom")) {
    out.push_back(
        fmt::format("{}: `metrics_file` is {}: node-exporter's textfile collector reads "
                    "only names that end with .prom",
                    file, metrics));
  }
  return out;
}

namespace {
std::string or_not_stated(const std::string& name) {
  return name.empty() ? "not stated: runs cannot prove that they share it" : name;
}
}  // namespace

std::string config_summary(const Config& config) {
  std::string out;
  const auto line = [&out](const char* key, const std::string& value) {
    out += fmt::format("  {:20}{}\n", key, value);
  };
  line("database", config.database);
  line("socket", config.socket);
  if (!config.metrics_file.empty()) line("metrics", config.metrics_file);
  if (config.bench) {
    line("rig", "simulated bench " + *config.bench);
    return out;
  }
  const bool weights = config.frame_driver == FrameDriver::dead_weight;
  line("meter", "at " + config.meter_port);
  line("frame", weights ? "dead weights" : "at " + config.frame_port);
  if (!weights) {
    const auto& stiffness = config.frame.stiffness_N_m;
    line("stiffness", stiffness ? fmt::format("{:g} N/mm", *stiffness * 1e-3)
                                : std::string("not stated: the frame counts as rigid"));
    const auto& cell = config.frame.stated.force_class;
    line("force class", cell ? fmt::format("{:g}", cell->percent())
                             : fmt::format("not stated: {:g} is assumed, unless the frame states "
                                           "another one",
                                           kAssumedForceClass.percent()));
    const auto from_frame = [](bool stated) {
      return std::string(stated ? "stated; the worse counts if the frame states it, too"
                                : "not stated: the frame has to state it (lcrig doctor)");
    };
    line("force loop", from_frame(config.frame.stated.force_loop.has_value()));
    line("step of travel", from_frame(config.frame.stated.travel_step.has_value()));
    line("load cell", or_not_stated(config.frame.cell_serial));
  }
  if (const auto& d = config.fixture.probe_diameter_m) {
    line("probe diameter", fmt::format("{:g} mm", *d * 1e3));
  }
  line("probe", or_not_stated(config.fixture.probe_serial.empty() ? config.fixture.probe_name
                                                                  : config.fixture.probe_serial));
  line("local gravity", fmt::format("{:g} m/s2", config.fixture.local_gravity_m_s2));
  line("wire logs", config.wire_log_directory.empty() ? "none" : "in " + config.wire_log_directory);
  return out;
}

Result<ConfigView> look_at_config_file(const std::string& file) {
  auto config = load_config(file);
  if (!config) return fail(config.error());
  if (auto good = check_surroundings(*config, file); !good) return fail(good.error());
  ConfigView out;
  out.file = file;
  out.warnings = config_warnings(*config, file);
  out.keys = keys_of(*config);
  return out;
}

}  // namespace lcrig
