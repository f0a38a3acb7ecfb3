// SPDX-License-Identifier: Apache-2.0
// config check, show.
#include <fmt/ostream.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/text.hpp"
#include "daemon/control/config_view.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

std::string file_of(const Context& context, const std::string& named) {
  if (!named.empty()) return named;
  return context.global.config.empty() ? context.env.daemon_config.string() : context.global.config;
}

Outcome<ConfigView> read_file(const Context& context, const std::string& file) {
  auto view = context.daemon.config(file);
  if (view) return std::move(*view);
  std::error_code unknown;
  const bool absent = !std::filesystem::exists(file, unknown) && !unknown;
  const char* first =
      absent ? "copy lcrigd.example.json (share/doc/lcrig/examples) there and adapt" : "correct";
  Failure out(view.error(),
              fmt::format("{} it, then lcrig config check {}", first, shell_quoted(file)));
  out.code = kFailed;
  return out;
}

void print_keys(std::ostream& out, const ConfigView& view) {
  for (const auto& k : view.keys) {
    fmt::print(out, "{:34} {:36} {}\n", k.key, printable(to_text(k.value), kLongestWords),
               k.waiting ? "waits" : to_string(k.source));
    if (!k.waiting) continue;
    fmt::print(out, "{:34} {:36} {}\n", "", printable(to_text(k.waiting->value), kLongestWords),
               k.waiting->effect == ConfigEffect::restart
                   ? "in the file: takes a restart of lcrigd"
                   : "in the file: as soon as the rig is idle");
  }
}

ExitCode tell(Context& context, const ConfigView& view, const std::string& headline) {
  for (const auto& warning : view.warnings) context.console.note(warning);
  return show(context, to_json(view), [&](std::ostream& out) {
    fmt::print(out, "{}\n", headline);
    print_keys(out, view);
  });
}

Outcome<ExitCode> config_check(Context& context, const std::string& file) {
  auto view = read_file(context, file_of(context, file));
  if (!view) return view.error();
  return tell(context, *view, printable(view->file) + ": in order");
}

constexpr OneWord kConfigCheck{"config check",
                               "Check a config file of the daemon, as lcrigd --check-config does",
                               "lcrig config check /etc/lcrig/lcrigd.json",
                               config_check,
                               kJsonFileWord,
                               "Without it: --config, else /etc/lcrig/lcrigd.json",
                               false};

Outcome<ConfigView> of_daemon(const Context& context) {
  auto socket = context.socket_path();
  if (!socket) return socket.error();
  auto client = ControlClient::connect(*socket, context.clock, context.env.daemon_patience);
  if (!client) return client.error();
  auto answer = client->call("config.show", json::object());
  if (!answer) return answer.error();
  auto view = parse_config_view(*answer);
  if (!view) return Failure(view.error());
  return std::move(*view);
}

Outcome<ExitCode> config_show(Context& context, const std::string&) {
  auto view = of_daemon(context);
  if (!view && !view.error().no_daemon) return view.error();
  if (view) {
    if (!view->refused.empty()) {
      context.console.note("the file was not taken when it was read again: " +
                           printable(view->refused, kLongestWords));
    }
    return tell(context, *view, "in force, of " + printable(view->file));
  }
  const auto file = file_of(context, "");
  context.console.note(fmt::format("{}; this is what {} says", view.error().what, file));
  view = read_file(context, file);
  if (!view) return view.error();
  return tell(context, *view, "of " + printable(view->file));
}

constexpr OneWord kConfigShow{"config show",
                              "The configuration in force, and where each value comes from",
                              "lcrig config show", config_show};

}  // namespace

const CommandFactory kConfigCheckCommand = make_command<OneWordCommand, kConfigCheck>;
const CommandFactory kConfigShowCommand = make_command<OneWordCommand, kConfigShow>;

}  // namespace lcrig::cli
