// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/rig_watch.hpp"

namespace lcrig {

using namespace std::chrono_literals;

Task<> RigWatch::ask() {
  const auto is_free = [this] { return use_.is_idle() || use_.is_ending(); };
  bool ready = false;
  // Also when somebody else found it not ready any more.
  const auto is_due = [this, &ready] {
    return use_.is_ending() || !known_.is_known(Instrument::lcr) ||
           (ready && !known_.is_ready(Instrument::lcr));
  };
  while (!use_.is_ending()) {
    use_.enter(RigUse::State::asking);
    const bool safe = co_await rescue_.make_safe();
    co_await rig_.ask_meter();
    use_.enter(RigUse::State::idle);
    ready = known_.is_ready(Instrument::lcr) && safe;
    const MonoTime next = clock_.now() + (ready ? 60s : 10s);
    co_await use_.wait(is_due, next);
    co_await use_.wait(is_free);
  }
}

Task<> RigWatch::watch_ports() {
  const auto is_over = [this] { return use_.is_ending(); };
  while (!use_.is_ending()) {
    if (use_.live_run() == nullptr) {
      const bool changed = co_await rig_.watch_ports();
      if (changed) use_.tell();
    }
    const MonoTime next = clock_.now() + 1s;
    co_await use_.wait(is_over, next);
  }
}

}  // namespace lcrig
