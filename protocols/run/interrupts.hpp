// SPDX-License-Identifier: Apache-2.0
// Requests that interrupt a step, and the queue in which they wait until the loop of the run has
// time for them. People who stop a run, the guard and the recovery put requests in; the run takes
// them out.
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
// stop_after: what was to be finished is finished; then `finally`. Never asked for in a step.
enum class Interrupt { pause, abort, freeze, limit, fault, loss, stop_after };
EventKind event_of(Interrupt i);  // whose word is the word of the interrupt

struct InterruptRequest {
  InterruptRequest() = default;
  InterruptRequest(Interrupt k, std::string w);
  InterruptRequest(Interrupt k, Error e) : kind(k), code(e.code), why(std::move(e.what)) {}
  Interrupt kind = Interrupt::abort;
  Errc code = Errc::aborted;
  std::string why;
};

// A step that failed is an interrupt that nobody asked for.
InterruptRequest request_for(const Error& error);

class InterruptQueue {
 public:
  // `look` is called every 100 ms while somebody waits: it pushes what nobody else would tell.
  InterruptQueue(asio::any_io_executor executor, Clock& clock, const EventLog& log,
                 std::function<void()> look);
  static constexpr Duration kTick = std::chrono::milliseconds(100);

  // From the io thread, at any time.
  // Result of a request: it acts; `finally` runs and goes on; the run is over.
  enum class Taken { acts, finally_goes_on, over };
  Taken ask(InterruptRequest request);
  // The same without an event and without asking whether it counts. A kind that already waits is
  // not added again, so nobody can fill the queue.
  void push(InterruptRequest request);
  bool empty() const { return pending_.empty(); }
  const InterruptRequest& next() const { return pending_.front(); }
  InterruptRequest take();  // the next one
  InterruptRequest take_stop();  // the next one that is no pause
  // Returns when a request waits, or at `until`. A request stays in the queue, so that a wait that
  // something else ended loses none.
  Task<> wait(MonoTime until = MonoTime::max());
  Task<> wait_for_stop();  // while nothing runs yet that a pause could interrupt

  // After a pause. `false`: somebody has resumed it already.
  bool resume() { return resumes_.try_send(boost::system::error_code()); }
  Task<> resumed();

  // A stop was asked for and has not been acted upon: more of them would be no news.
  bool stop_pending() const { return stop_pending_; }
  // The run ends. From now on only what makes `finally` dangerous interrupts it. Returns what the
  // run is stopped for: `stop`, or a request that came in its last instant.
  std::optional<InterruptRequest> begin_finish(std::optional<InterruptRequest> stop);
  void expect_no_stop() { stop_pending_ = false; }  // `finally` has ended
  bool finishing() const { return finishing_; }
  void close() { over_ = true; }  // nothing can be asked any more
  bool over() const { return over_; }

  // For the watchdog, and to tell whether this program itself stood still.
  std::uint64_t ticks() const { return ticks_; }
  MonoTime last_tick() const { return last_tick_; }

 private:
  using WakeChannel = asio::experimental::channel<void(boost::system::error_code)>;

  Clock& clock_;
  const EventLog& log_;
  std::function<void()> look_;
  std::deque<InterruptRequest> pending_;
  WakeChannel wake_, resumes_;
  bool stop_pending_ = false, finishing_ = false, over_ = false;
  std::uint64_t ticks_ = 0;
  MonoTime last_tick_{};
};

}  // namespace lcrig
