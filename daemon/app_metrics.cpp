// SPDX-License-Identifier: Apache-2.0
// The daemon's health for who asks, and as a file for node-exporter.
#include <spdlog/spdlog.h>

#include "base/aside.hpp"
#include "base/text.hpp"
#include "base/whole_file.hpp"
#include "daemon/app.hpp"
#include "daemon/metrics.hpp"

namespace lcrig {

using namespace std::chrono_literals;

Task<Result<std::string>> App::metrics() {
  if (measuring_) co_return fail(Errc::busy, "somebody else is being told: try again");
  measuring_ = true;
  const auto read = [this] { return read_system_figures(config_.database); };
  Metrics out;
  out.system = co_await run_aside(io_.get_executor(), clock_, read);
  measuring_ = false;
  out.status = status();
  if (recorder_) out.commits = recorder_->stats();
  out.worst_lateness = lag_.worst();
  out.events = events_;
  co_return to_text(out);
}

// A file that cannot be written is told once, until it could be.
Task<> App::write_metrics() {
  const auto is_over = [this] { return shutting_down_; };
  bool told = false;
  const auto is_wanted = [this] { return shutting_down_ || !config_.metrics_file.empty(); };
  for (;;) {
    co_await changed_.wait(is_wanted);
    if (shutting_down_) co_return;
    const std::string file = config_.metrics_file;
    auto text = co_await metrics();
    if (text) {
      const auto write = [&file, &text] { return write_whole_file(file, *text); };
      auto written = co_await run_aside(io_.get_executor(), clock_, write);
      if (!written && !told) {
        spdlog::warn("no metrics are written: {}", printable(written.error().what));
      }
      told = !written;
    }
    const MonoTime next = clock_.now() + 15s;
    co_await changed_.wait(is_over, next);
  }
}

}  // namespace lcrig
