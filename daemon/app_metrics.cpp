// SPDX-License-Identifier: Apache-2.0
// The daemon's health for who asks, and as a file for node-exporter.
#include <spdlog/spdlog.h>

#include <filesystem>

#include "base/aside.hpp"
#include "base/text.hpp"
#include "base/whole_file.hpp"
#include "daemon/app.hpp"
#include "daemon/metrics.hpp"

namespace lcrig {

using namespace std::chrono_literals;

namespace {

// The collector runs as another user, and the service's umask lets only its group read.
Result<> write_for_collector(const std::string& file, std::string_view text) {
  auto part = PartFile::create(file);
  if (!part) return fail(part.error());
  if (auto opened = part->open_to_all(); !opened) return opened;
  if (auto written = write_text(part->fd(), file, text); !written) return written;
  return part->replace();
}

// A collector would go on serving an old file for ever.
void remove_old(const std::string& file) {
  std::error_code unknown;
  if (!file.empty()) std::filesystem::remove(file, unknown);
}

}  // namespace

Task<Result<std::string>> App::metrics() {
  const auto is_free = [this] { return !measuring_; };
  co_await changed_.wait(is_free);
  measuring_ = true;
  const auto read = [this] { return read_system_figures(config_.database); };
  Metrics out;
  out.system = co_await run_aside(io_.get_executor(), clock_, read);
  measuring_ = false;
  changed_.notify_all();
  out.status = status();
  if (recorder_) out.commits = recorder_->stats();
  out.worst_lateness = lag_.worst();
  out.events = events_;
  co_return to_text(out);
}

// A file that cannot be written is told once, until it could be. It goes when the daemon ends, and
// when the configuration names another one or none.
Task<> App::write_metrics() {
  bool told = false;
  std::string file;
  const auto is_another = [this, &file] { return shutting_down_ || config_.metrics_file != file; };
  for (;;) {
    if (file.empty()) co_await changed_.wait(is_another);
    if (is_another()) remove_old(file);
    if (shutting_down_) co_return;
    file = config_.metrics_file;
    if (file.empty()) continue;
    auto text = co_await metrics();
    if (text) {
      const auto write = [&file, &text] { return write_for_collector(file, *text); };
      auto written = co_await run_aside(io_.get_executor(), clock_, write);
      if (!written && !told) {
        spdlog::warn("no metrics are written: {}", printable(written.error().what));
      }
      told = !written;
    }
    const MonoTime next = clock_.now() + 15s;
    co_await changed_.wait(is_another, next);
  }
}

}  // namespace lcrig
