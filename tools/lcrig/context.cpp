// SPDX-License-Identifier: Apache-2.0
#include <pwd.h>
#include <unistd.h>

#include <array>

#include "base/strict_json.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

namespace {

// One path of the daemon's configuration; the daemon checks the rest of the file.
Outcome<std::optional<std::string>> configured(const std::string& file, const char* key) {
  auto document = load_json(file);
  if (!document) return Failure(document.error(), "give another --config");
  const JsonReader reader(*document);
  auto value = reader.optional_string(key);
  if (auto ok = reader.result(); !ok) {
    return Failure(ok.error(), "correct the file, or leave --config out");
  }
  return value;
}

}  // namespace

Outcome<std::string> Context::db_path() const {
  if (!global.db.empty()) return global.db;
  if (!global.config.empty()) {
    auto path = configured(global.config, "database");
    if (!path) return path.error();
    if (*path) return **path;
  }
  return env.default_db().string();
}

Outcome<std::string> Context::socket_path() const {
  if (!global.socket.empty()) return global.socket;
  if (!global.config.empty()) {
    auto path = configured(global.config, "socket");
    if (!path) return path.error();
    if (*path) return **path;
  }
  return env.default_socket().string();
}

bool Context::prefers_daemon_db() const {
  return global.db.empty() && global.config.empty() && env.default_db() == env.daemon_db;
}

Outcome<ParameterValues> parse_assignments(const std::vector<std::string>& words) {
  ParameterValues out;
  for (const auto& word : words) {
    const auto equals = word.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == word.size()) {
      return Failure(kUsage, fmt::format("-p {}: expected name=value, like -p cycles=5", word),
                     "lcrig protocol show PROTOCOL   (lists its parameters)");
    }
    const auto name = word.substr(0, equals);
    if (!out.emplace(name, word.substr(equals + 1)).second) {
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
