// SPDX-License-Identifier: Apache-2.0
// Requests that interrupt a step, and the queue in which they wait for the run's loop. People who
// stop a run, the guard and the recovery add requests; the run takes them out.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "protocols/run/event_log.hpp"

namespace lcrig {

// pause: hold travel, go on later. abort: stop now, then `finally`. freeze: stop now and stay.
// limit and fault are aborts that nobody asked for; the run has failed.
// loss: an instrument vanished; the protocol's `on_loss` decides.
// stop_after: the part that a person named is done; then `finally`. Never comes within a step.
enum class Interrupt { pause, abort, freeze, limit, fault, loss, stop_after };
EventKind event_of(Interrupt i);  // the event that reports the interrupt

struct InterruptRequest {
  InterruptRequest() = default;
  InterruptRequest(Interrupt k, std::string w);
  InterruptRequest(Interrupt k, Error e)
      : kind(k), code(e.code), why(std::move(e.what)), hands_off(e.hands_off) {}
  Interrupt kind = Interrupt::abort;
  Errc code = Errc::aborted;
  std::string why;
  bool hands_off = false;  // as in Error
};

// A step that failed becomes an interrupt that nobody asked for.
InterruptRequest request_for(const Error& error);

class InterruptQueue {
 public:
  // `look` is called every 100 ms while somebody waits. It adds requests for conditions that cause
  // no event.
  InterruptQueue(asio::any_io_executor executor, Clock& clock, const EventLog& log,
                 std::function<void()> look);
  static constexpr Duration kTick = std::chrono::milliseconds(100);

  // Call from the io thread, at any time.
  // Result of a request: it acts; `finally` is running and goes on; the run is over.
  enum class Taken { acts, finally_goes_on, over };
  Taken ask(InterruptRequest request);
  // Adds a request without an event or a check. A kind that already waits is not added again, so
  // the queue stays short.
  void push(InterruptRequest request);
  bool empty() const { return pending_.empty(); }
  const InterruptRequest& next() const { return pending_.front(); }
  InterruptRequest take();  // the next one
  InterruptRequest take_stop();  // the next one other than a pause
  // Returns when a request waits, or at `until`. The request stays in the queue, so that none is
  // lost when something else ends the wait.
  Task<> wait(MonoTime until = MonoTime::max());
  Task<> wait_for_stop();  // for the time before a pause has anything to interrupt

  // Ends a pause. `false`: another call has ended it already.
  bool resume() { return resumes_.try_send(boost::system::error_code()); }
  Task<> resumed();

  // A stop was asked for and is not carried out yet, so another one changes nothing.
  bool stop_pending() const { return stop_pending_; }
  // Call when the run ends. From now on only requests that make `finally` dangerous interrupt it.
  // Returns the reason of the stop: `stop`, or a request that came in the last instant.
  std::optional<InterruptRequest> begin_finish(std::optional<InterruptRequest> stop);
  void expect_no_stop() { stop_pending_ = false; }  // call after `finally`
  bool finishing() const { return finishing_; }
  bool frozen() const { return frozen_; }
  void close() { over_ = true; }  // nothing can be asked for any more
  bool over() const { return over_; }

  std::uint64_t ticks() const { return ticks_; }  // for the watchdog
  // By how much this program itself is late, or was within the last second: it was suspended, or
  // had no processor. What arrived meanwhile waited here, and not at the instruments. nullopt:
  // nobody waits, so it is not known.
  std::optional<Duration> own_lag(MonoTime now) const;

 private:
  using WakeChannel = asio::experimental::channel<void(boost::system::error_code)>;

  void note_lag();

  Clock& clock_;
  const EventLog& log_;
  std::function<void()> look_;
  std::deque<InterruptRequest> pending_;
  WakeChannel wake_, resumes_;
  bool stop_pending_ = false, finishing_ = false, over_ = false;
  bool frozen_ = false;  // a freeze was asked for: `finally` does not move
  std::uint64_t ticks_ = 0;
  std::optional<MonoTime> due_;  // of the next tick; none: nobody waits
  MonoTime lagged_{};  // when the last lag was seen
  Duration lag_{};
};

}  // namespace lcrig
