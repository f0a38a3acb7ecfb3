// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/process_env.hpp"

#include <pwd.h>
#include <sys/auxv.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string_view>
#include <system_error>

namespace lcrig::cli {

namespace fs = std::filesystem;

fs::path ProcessEnv::user_db() const {
  const auto data = get("XDG_DATA_HOME");
  // The specification says that a relative path is to be ignored.
  if (data && fs::path(*data).is_absolute()) return fs::path(*data) / "lcrig" / "lcrig.db";
  const auto home = get("HOME");
  return fs::path(home.value_or(".")) / ".local" / "share" / "lcrig" / "lcrig.db";
}

fs::path ProcessEnv::rehearsal_db() const {
  if (auto given = get("LCRIG_DB")) return *given;
  return user_db();
}

fs::path ProcessEnv::default_db() const {
  if (auto given = get("LCRIG_DB")) return *given;
  std::error_code ignored;
  if (fs::exists(daemon_db, ignored)) return daemon_db;
  return user_db();
}

fs::path ProcessEnv::default_socket() const {
  if (auto given = get("LCRIG_SOCKET")) return *given;
  return daemon_socket;
}

namespace {

// Home directory of the user. cron or a service may start a program without $HOME, and a database
// in the current folder would never be found again.
std::optional<std::string> home_of_user() {
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> text{};
  ::getpwuid_r(::getuid(), &entry, text.data(), text.size(), &found);
  if (found == nullptr || *found->pw_dir == '\0') return std::nullopt;
  return found->pw_dir;
}

}  // namespace

ProcessEnv real_process_env() {
  ProcessEnv env;
  env.variable = [](const char* name) -> std::optional<std::string> {
    const char* value = std::getenv(name);
    if (value != nullptr && *value != '\0') return value;
    return std::string_view(name) == "HOME" ? home_of_user() : std::nullopt;
  };
  std::error_code ignored;
  env.executable = fs::read_symlink("/proc/self/exe", ignored);
  if (env.executable.empty()) {  // without /proc: the name by which the kernel started it
    env.executable = fs::canonical(reinterpret_cast<const char*>(::getauxval(AT_EXECFN)), ignored);
  }
  return env;
}

}  // namespace lcrig::cli
