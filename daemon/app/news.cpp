// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/news.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "base/text.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/control/server.hpp"
#include "daemon/run_words.hpp"
#include "daemon/service.hpp"
#include "daemon/session.hpp"
#include "events/event_words.hpp"
#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

// Events that the journal shows, besides the start and end of a run, and lost instruments
// (protocols/run/losses.cpp).
bool is_for_journal(EventKind kind) {
  return kind == EventKind::limit || kind == EventKind::stop_failed || kind == EventKind::loaded ||
         kind == EventKind::device_travel_step || kind == EventKind::device_force_step;
}

std::string for_whom(const std::string& operator_name) {
  return operator_name.empty() ? "" : ", for " + printable(operator_name);
}

}  // namespace

void News::run_begins(std::int64_t run) const {
  const Session& session = *use_.session();
  const RunProgress begun = use_.live_run()->progress();
  spdlog::info("{} begins: {} on {}{}", run_words(session.simulated(), run),
               printable(begun.protocol), printable(begun.specimen),
               for_whom(session.operator_name()));
}

void News::status() const {
  if (server_.watched() && use_.live_run() != nullptr) {
    server_.publish_status(use_.session()->status());
  }
}

void News::service_status() {
  const std::string& trouble = server_.trouble();
  const bool had_trouble = std::exchange(told_trouble_, !trouble.empty());
  if (!trouble.empty()) return notifier_.status("no client finds the daemon: " + trouble);
  if (use_.live_run() != nullptr) return notifier_.status(service_line(use_.session()->status()));
  if (use_.state() == RigUse::State::stopping) {
    return notifier_.status(alarm_words_after(use_.last_run()->run));
  }
  if (had_trouble) notifier_.status(idle_words_);
}

void News::event(const RunEvent& event) const {
  for (const auto& watcher : watchers_) watcher(event);
  if (!server_.is_listening() || is_for_replay(event.kind.kind())) return;
  RunEventNote note;
  note.run = use_.live_run() != nullptr ? use_.live_run()->progress().run : 0;
  if (is_for_journal(event.kind.kind())) {
    spdlog::warn("run {}: {}: {}", note.run, event.kind.word(),
                 printable(event_words(event.detail)));
  }
  note.event = event;
  server_.publish_event(note);
}

void News::run_ended(const RunOutcome& ended) const {
  server_.publish_run_ended(ended);
  spdlog::info("{}", ended_line(ended));
}

void News::queue_changed(const QueueStatus& status) {
  server_.publish_queue(status);
  idle_words_ = status.prompt.empty() ? "idle" : "the queue waits: " + status.prompt;
  if (use_.live_run() == nullptr) notifier_.status(idle_words_);
}

}  // namespace lcrig
