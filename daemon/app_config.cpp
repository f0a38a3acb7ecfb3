// SPDX-License-Identifier: Apache-2.0
// The config file while the daemon runs (SIGHUP).
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/aside.hpp"
#include "base/log.hpp"
#include "daemon/app.hpp"
#include "daemon/config_check.hpp"

namespace lcrig {

namespace {

// An entry of the log for each line: a journal has no others.
void log_lines(std::string_view text) {
  while (!text.empty()) {
    const auto line = text.substr(0, text.find('\n'));
    if (!line.empty()) spdlog::error("{}", line);
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
}

}  // namespace

// Beside the loop: a disk that takes its time holds up no run.
Task<> App::reload() {
  if (!load_config_ || shutting_down_) co_return;
  notifier_.reloading(clock_.now());
  auto wanted = co_await run_aside(io_.get_executor(), clock_, load_config_);
  // A daemon that ends meanwhile has said so, and is not ready again.
  if (shutting_down_) co_return;
  if (wanted) {
    take_config(std::move(*wanted));
  } else {
    const Error& why = wanted.error();
    spdlog::error("{}", why.what);
    log_lines(why.detail);
    spdlog::error("the config file is not taken: lcrigd goes on with what it had");
    reload_.refuse(why.what);
  }
  notifier_.ready();
  if (use_ == Use::idle) notifier_.status(wanted ? "idle" : "idle; the config file is not taken");
}

void App::take_config(Config wanted) {
  const std::string file = wanted.file;
  for (const auto& warning : config_warnings(wanted, file)) spdlog::warn("{}", warning);
  const auto told = reload_.take(std::move(wanted), use_ == Use::idle);
  spdlog::info("{}: read again{}", file, told.empty() ? ": nothing is different" : "");
  for (const auto& line : told) spdlog::info("config: {}", line);
  config_changed();
}

void App::config_changed() {
  set_log_level(config_.log_level);
  if (use_ == Use::idle) {
    plans_.forget_rigs();  // the fixture may be another one
    if (real_ != nullptr) real_->config_changed();
  }
  changed_.notify_all();
}

}  // namespace lcrig
