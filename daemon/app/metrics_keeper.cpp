// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/metrics_keeper.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>

#include "base/aside.hpp"
#include "base/clock.hpp"
#include "base/text.hpp"
#include "base/whole_file.hpp"
#include "daemon/app/heartbeat.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/config.hpp"
#include "daemon/metrics.hpp"
#include "daemon/record/recorder.hpp"

namespace lcrig {

using namespace std::chrono_literals;

namespace {

// Makes the file readable for everybody: the collector runs as another user, and the service's
// umask would allow only its group.
Result<> write_for_collector(const std::string& file, std::string_view text) {
  auto part = PartFile::create(file);
  if (!part) return fail(part.error());
  if (auto opened = part->open_to_all(); !opened) return opened;
  if (auto written = write_text(part->fd(), file, text); !written) return written;
  return part->replace();
}

// Removes an old file, because a collector would serve it for ever.
void remove_old(const std::string& file) {
  std::error_code unknown;
  if (!file.empty()) std::filesystem::remove(file, unknown);
}

}  // namespace

Task<Result<std::string>> MetricsKeeper::text() {
  const auto is_free = [this] { return !measuring_; };
  co_await free_.wait(is_free);
  measuring_ = true;
  const auto read = [this] { return read_system_figures(parts_.config.database); };
  Metrics out;
  out.system = co_await run_aside(executor_, clock_, read);
  measuring_ = false;
  free_.notify_all();
  out.status = parts_.status();
  if (parts_.recorder) out.commits = parts_.recorder->stats();
  out.worst_lateness = parts_.heartbeat.worst_lateness();
  out.events = events_;
  co_return to_text(out);
}

// Reports a file that cannot be written once, until writing works again. Removes the file when the
// daemon ends, and when the configuration names another file or none.
Task<> MetricsKeeper::write() {
  const std::string& wanted = parts_.config.metrics_file;
  bool told = false;
  std::string file;
  const auto is_another = [this, &file, &wanted] {
    return parts_.use.is_ending() || wanted != file;
  };
  for (;;) {
    if (file.empty()) co_await parts_.use.wait(is_another);
    if (is_another()) remove_old(file);
    if (parts_.use.is_ending()) co_return;
    file = wanted;
    if (file.empty()) continue;
    auto page = co_await text();
    if (page) {
      const auto write = [&file, &page] { return write_for_collector(file, *page); };
      auto written = co_await run_aside(executor_, clock_, write);
      if (!written && !told) {
        spdlog::warn("no metrics are written: {}", printable(written.error().what));
      }
      told = !written;
    }
    const MonoTime next = clock_.now() + 15s;
    co_await parts_.use.wait(is_another, next);
  }
}

}  // namespace lcrig
