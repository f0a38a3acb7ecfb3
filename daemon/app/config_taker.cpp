// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/config_taker.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/aside.hpp"
#include "base/log.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/config_check.hpp"
#include "daemon/queue/plans.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/service.hpp"

namespace lcrig {

namespace {

// One log entry for each line, because a journal has no entries of several lines.
void log_lines(std::string_view text) {
  while (!text.empty()) {
    const auto line = text.substr(0, text.find('\n'));
    if (!line.empty()) spdlog::error("{}", line);
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
}

}  // namespace

// Reads the file aside, so that a slow disk does not delay a run.
Task<> ConfigTaker::reload() {
  if (!parts_.load || parts_.use.is_ending()) co_return;
  parts_.notifier.reloading(clock_.now());
  auto wanted = co_await run_aside(executor_, clock_, parts_.load);
  // A daemon that is ending by now has told systemd so, and is not ready again.
  if (parts_.use.is_ending()) co_return;
  if (wanted) {
    take(std::move(*wanted));
  } else {
    const Error& why = wanted.error();
    spdlog::error("{}", why.what);
    log_lines(why.detail);
    spdlog::error("the config file is not taken: lcrigd goes on with what it had");
    reload_.refuse(why.what);
  }
  parts_.notifier.ready();
  if (!parts_.use.is_idle()) co_return;
  parts_.notifier.status(wanted ? "idle" : "idle; the config file is not taken");
}

void ConfigTaker::take(Config wanted) {
  const std::string file = wanted.file;
  for (const auto& warning : config_warnings(wanted, file)) spdlog::warn("{}", warning);
  const auto told = reload_.take(std::move(wanted), parts_.use.is_idle());
  spdlog::info("{}: read again{}", file, told.empty() ? ": nothing is different" : "");
  for (const auto& line : told) spdlog::info("config: {}", line);
  changed();
}

void ConfigTaker::take_when_idle() {
  const auto taken = reload_.take_when_idle();
  for (const auto& line : taken) spdlog::info("config: {}", line);
  if (!taken.empty()) changed();
}

void ConfigTaker::changed() {
  set_log_level(parts_.config.log_level);
  if (parts_.use.is_idle()) {
    parts_.plans.forget_rigs();  // the fixture may have changed
    parts_.rig.config_changed();
  }
  parts_.use.tell();
}

}  // namespace lcrig
