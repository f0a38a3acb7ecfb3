// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/heartbeat.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "base/clock.hpp"
#include "daemon/app/news.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/service.hpp"
#include "daemon/session.hpp"
#include "protocols/run/run.hpp"

namespace lcrig {

using namespace std::chrono_literals;

namespace {

constexpr Duration kStatusInterval = 100ms;
// Longer than any legitimate wait. The runner wakes four times a second, but closing a run may wait
// for STOP (2 s), a last conversion (5 s) and a frame that vanished (5 s); a commit waits 5 s for a
// lock.
constexpr Duration kRunnerPatience = 20s;
constexpr Duration kSamplerPatience = 1s;  // beyond the longest exchange
constexpr Duration kRecorderPatience = 10s;

}  // namespace

Heartbeat::Heartbeat(Clock& clock, const Parts& parts) : clock_(clock), parts_(parts) {
  using Beats = std::optional<std::uint64_t>;
  liveness_.watch("the runner", kRunnerPatience, [this]() -> Beats {
    if (parts_.use.live_run() == nullptr) return std::nullopt;
    return parts_.use.session()->beats();
  });
  liveness_.watch("the sampler", kSamplerPatience, [this]() -> Beats {
    const Run* run = parts_.use.live_run();
    if (run == nullptr) return std::nullopt;
    return run->sampler().overdue(clock_.now());
  });
  liveness_.watch("the recorder", kRecorderPatience, [this] { return parts_.recorder->beats(); });
}

// Reports a part that hangs once, and stops the run while that is still possible.
bool Heartbeat::is_working() {
  auto stuck = liveness_.check(clock_.now());
  const bool is_news = stuck.empty() != stuck_.empty();
  stuck_ = std::move(stuck);
  if (!is_news) return stuck_.empty();
  if (stuck_.empty()) {
    spdlog::info("every part moves again");
    parts_.notifier.status("every part moves again");
    return true;
  }
  spdlog::critical("{}; systemd's watchdog is not fed any more", stuck_.front());
  if (Run* run = parts_.use.live_run()) {
    run->interrupt(InterruptRequest(Interrupt::fault, Error(Errc::bug, stuck_.front())));
  }
  return false;
}

// Updates the line that `systemctl status` shows. A stuck part is more important than the state of
// the run. While all parts move, a stop may take as long as `finally` takes.
void Heartbeat::tell_service(bool working) const {
  if (!working) return parts_.notifier.status("stuck: " + stuck_.front());
  parts_.news.service_status();
  if (parts_.rig.is_computing()) parts_.notifier.status("computes the simulated specimen");
  if (parts_.use.is_ending() && parts_.use.session() != nullptr) {
    parts_.notifier.extend_timeout(kStopExtension);
  }
}

Task<> Heartbeat::run() {
  MonoTime watchdog_due = clock_.now(), second_due = watchdog_due;
  const Duration watchdog = parts_.notifier.watchdog_interval().value_or(1h);
  while (!parts_.use.is_ending() || parts_.use.session() != nullptr) {
    parts_.news.status();
    const bool working = is_working();
    if (clock_.now() >= second_due) {
      second_due = clock_.now() + 1s;
      tell_service(working);
    }
    if (clock_.now() >= watchdog_due && working) {
      parts_.notifier.watchdog();
      watchdog_due = clock_.now() + watchdog;
    }
    const MonoTime due = clock_.now() + std::min(kStatusInterval, watchdog);
    // Not an event: force and travel change all the time, and watchers get them ten times a second.
    co_await clock_.wait_until(due);
    if (const auto late = lag_.note(due, clock_.now())) tell_lag(*late);
  }
}

// Reports at most one lag in ten seconds, because a machine that swaps is late all the time.
void Heartbeat::tell_lag(Duration late) {
  const MonoTime now = clock_.now();
  if (now - lag_told_ < 10s && lag_told_ != MonoTime()) return;
  lag_told_ = now;
  const std::string text = fmt::format("the event loop was {:.0f} ms late", to_seconds(late) * 1e3);
  spdlog::warn("{}", text);
  if (parts_.use.live_run() == nullptr) return;
  parts_.recorder->event(RunEvent(now, EventKind::lag, "", text));
}

}  // namespace lcrig
