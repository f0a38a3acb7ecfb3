// SPDX-License-Identifier: Apache-2.0
#include <pwd.h>
#include <unistd.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/strict_json.hpp"
#include "storage/writer_lock.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig::cli {

namespace {

// One path from the daemon's configuration. Checking the rest of the file is the daemon's business.
Outcome<std::optional<std::string>> configured(const std::string& file, const char* key) {
  auto document = load_json(file);
  if (!document) return Failure(document.error(), "give another --config");
  const JsonReader reader(*document);
  reader.expect_format("lcrigd-config/1");
  auto value = reader.optional_string(key);
  if (auto ok = reader.result(); !ok) {
    return Failure(ok.error(), "correct the file, or leave --config out");
  }
  return value;
}

// Failure: as ControlClient::database.
Outcome<std::string> database_of_daemon(const std::string& socket, const Clock& clock,
                                        Duration patience) {
  auto client = ControlClient::connect(socket, clock, patience);
  if (!client) return client.error();
  return client->database(patience);
}

}  // namespace

Outcome<std::string> Context::socket_path() const {
  if (!global.socket.empty()) return global.socket;
  if (!global.config.empty()) {
    auto path = configured(global.config, "socket");
    if (!path) return path.error();
    if (*path) return **path;
  }
  return env.default_socket().string();
}

Outcome<std::optional<std::string>> Context::named_db() const {
  if (!global.db.empty()) return std::optional(global.db);
  if (!global.config.empty()) {
    auto path = configured(global.config, "database");
    if (!path || *path) return path;
  }
  if (!global.socket.empty() || !global.config.empty()) return std::optional<std::string>();
  return env.get("LCRIG_DB");
}

// The default database, for when no file was named and no daemon answered. It is surely the one
// that is meant if no daemon was named and no socket exists.
ChosenDatabase Context::without_daemon(const std::string& socket, const Failure& why) const {
  ChosenDatabase out;
  out.path = env.default_db().string();
  out.daemon_writes = out.path == env.daemon_db;
  const bool named = !global.socket.empty() || !global.config.empty() || env.get("LCRIG_SOCKET");
  std::error_code ignored;
  const auto found = std::filesystem::symlink_status(socket, ignored).type();
  if (named || found != std::filesystem::file_type::not_found) {
    out.unsure = why;
  }
  return out;
}

Outcome<ChosenDatabase> Context::database() const {
  auto chosen = choose_database();
  if (chosen && chosen->unsure && !std::exchange(told_unsure_, true)) {
    console.note(fmt::format("{}; uses {}", chosen->unsure->what, chosen->path));
  }
  return chosen;
}

Outcome<ChosenDatabase> Context::database_to_write(const std::vector<std::string>& typed) const {
  auto chosen = choose_database();
  if (!chosen || chosen->daemon_writes) return chosen;
  if (chosen->unsure) {
    Failure unsure = *chosen->unsure;
    if (unsure.no_daemon) {
      unsure.next = "systemctl status lcrigd   (or name the database that is meant: --db FILE)";
    }
    unsure.code = kUnreachable;
    return unsure;
  }
  const auto written = has_writer(chosen->path);
  if (!written) return Failure(written.error());
  if (!*written) return chosen;
  GlobalOptions of_daemon;
  of_daemon.socket = "SOCKET";
  return Failure(kFailed,
                 fmt::format("{}: a daemon records into it, or a rehearsal, and nobody else writes",
                             chosen->path),
                 next_command(of_daemon, typed, "the socket of that daemon, and no --db"));
}

Outcome<ChosenDatabase> Context::choose_database() const {
  if (chosen_) return *chosen_;
  auto named = named_db();
  if (!named) return named.error();
  auto socket = socket_path();
  if (!socket) return socket.error();
  const auto daemons = database_of_daemon(*socket, clock, env.daemon_patience);
  ChosenDatabase out;
  if (*named) {
    out.path = **named;
    out.daemon_writes = daemons && is_same_file(out.path, *daemons);
    if (daemons && !out.daemon_writes) {
      console.note(fmt::format("uses {}; the daemon at {} has another database, {}", out.path,
                               *socket, *daemons));
    }
  } else if (daemons) {
    out.path = *daemons;
    out.daemon_writes = true;
  } else {
    out = without_daemon(*socket, daemons.error());
  }
  chosen_ = out;
  return out;
}

Outcome<std::string> Context::db_path() const {
  auto chosen = database();
  if (!chosen) return chosen.error();
  return chosen->path;
}

std::optional<std::pair<std::string, std::string>> split_assignment(const std::string& word) {
  const auto equals = word.find('=');
  if (equals == 0 || equals == word.npos || equals + 1 == word.size()) return std::nullopt;
  return std::pair(word.substr(0, equals), word.substr(equals + 1));
}

Outcome<ParameterValues> parse_assignments(const std::string& protocol,
                                           const std::vector<std::string>& words) {
  ParameterValues out;
  for (const auto& word : words) {
    auto one = split_assignment(word);
    if (!one) {
      return Failure(
          kUsage, fmt::format("-p {}: expected name=value, like -p cycles=5", word),
          next_command(GlobalOptions(), {"protocol", "show", protocol}, "lists its parameters"));
    }
    if (!out.insert(std::move(*one)).second) {
      const auto name = word.substr(0, word.find('='));
      return Failure(kUsage, fmt::format("-p {}: was given twice", name), "give it once");
    }
  }
  return out;
}

std::string login_name() {
  std::array<char, 4096> buffer{};
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(::getuid(), &entry, buffer.data(), buffer.size(), &found) == 0 &&
      found != nullptr) {
    return found->pw_name;
  }
  return std::to_string(::getuid());
}

}  // namespace lcrig::cli
