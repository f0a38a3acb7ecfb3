// SPDX-License-Identifier: Apache-2.0
// The daemon's end of frame-link/1. Used by the driver only. One coroutine reads and dispatches
// lines, the other writes lines and heartbeats. The meaning of commands is in driver.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "drivers/load_frame.hpp"
#include "drivers/transport.hpp"
#include "drivers/zwick/codec.hpp"

namespace lcrig::frame_link {

// Shared by ZwickLink and the two coroutines, so that none of them outlives it. The Clock must
// outlive the io_context.
class Link : public std::enable_shared_from_this<Link> {
 public:
  Link(std::unique_ptr<Transport> transport, Clock& clock, asio::any_io_executor executor);

  // A wait for lines of the link. While it exists, every relevant line wakes it.
  class Waiting {
   public:
    explicit Waiting(std::shared_ptr<Link> link);
    ~Waiting();
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;
    // Waits for the next line, the deadline or the loss of the link. Errors: disconnected (link
    // lost), aborted (the calling task was cancelled).
    Task<Result<>> next(std::optional<MonoTime> deadline);
    Link& link() { return *link_; }

   private:
    std::shared_ptr<Link> link_;
    Wakeup wakeup_;
  };

  // One numbered command. Answers that come after it was destroyed are dropped.
  class Exchange {
   public:
    explicit Exchange(std::shared_ptr<Link> link);
    ~Exchange();
    Exchange(const Exchange&) = delete;
    Exchange& operator=(const Exchange&) = delete;

    const std::int64_t number;
    const std::int64_t stops;  // number of STOPs sent before it
    Waiting waiting;
    std::optional<Result<>> answer;  // the gateway's OK or ERR
    std::optional<MotionOutcome> done;
  };

  void start();  // idempotent
  // idempotent; ends both coroutines and every wait
  void close() { end(Error(Errc::disconnected, name() + ": closed")); }
  void send(std::string_view line) { queue(line); }
  // Asks for a session that may command. Sends STOP first, because a previous daemon may have died,
  // and a gateway that does not answer HELLO may still move.
  void send_hello();
  void send_observe(double rate_Hz);  // asks for a session that may not command
  void give_up_greeting();  // a HELLO that comes later is not taken for the answer
  // Sends STOP ahead of everything queued. Returns the number of STOPs sent in this session.
  std::int64_t send_stop();
  bool is_stopped(std::int64_t stops) const { return stopped_ >= stops; }

  // True when HELLO and CAPS have arrived for the latest session that was asked for.
  bool is_greeted() const { return identity_ && caps_ && hellos_owed_ == 0 && !caps_owed_; }
  bool is_observer() const { return observer_; }
  const std::optional<Hello>& hello() const { return identity_; }
  const std::optional<FrameCapabilities>& caps() const { return caps_; }
  // Printable; nullopt: a gateway of revision 1.
  const std::optional<std::string>& origin() const { return origin_; }
  const std::string& last_garbage() const { return garbage_; }  // printable; empty: none
  const std::string& why_garbage() const { return garbage_why_; }
  const std::optional<Error>& lost() const { return lost_; }
  const std::string& name() const { return transport_->name(); }
  Clock& clock() { return clock_; }
  void set_listener(LoadFrame::Listener* listener) { listener_ = listener; }

 private:
  Task<> read();
  Task<> write();
  void lose(Error error);
  void end(Error error);
  void queue(std::string_view line);
  void greet(std::string_view line);
  void knock() {
    for (Wakeup* w : waiting_) w->notify();
  }
  void event(EventName kind, std::string detail);

  void dispatch(std::string_view text);
  void dispatch_report(const Line& line);
  void on_hello(const Line& line);
  void on_caps(const Line& line);
  void on_event(const Line& line);
  void take_origin(const Line& line);
  void on_answer(const Line& line);
  void on_done(const Line& line);
  void on_stopped(const Line& line);
  void on_samples(const Line& line);
  void on_garbage(std::string_view text, std::string_view why);
  void check_sequence();
  void check_device_clock();

  std::unique_ptr<Transport> transport_;
  Clock& clock_;
  asio::any_io_executor executor_;
  LoadFrame::Listener* listener_ = nullptr;
  bool started_ = false;
  std::optional<Error> lost_;  // also set by close()

  Wakeup writer_;
  std::string queue_;  // complete lines
  std::string urgent_;  // STOPs
  MonoTime sent_, heard_;
  std::array<char, 8192> buffer_{};
  LineSplitter splitter_;
  std::size_t dropped_ = 0;

  std::optional<Hello> identity_;
  std::optional<FrameCapabilities> caps_;
  std::optional<std::string> origin_;
  int hellos_owed_ = 0;
  bool caps_owed_ = false;
  bool observer_ = false;
  std::string garbage_, garbage_why_;
  MonoTime garbage_reported_;
  std::int64_t garbage_count_ = 0;  // lines since the last report

  std::vector<Wakeup*> waiting_;
  std::map<std::int64_t, Exchange*> exchanges_;
  std::int64_t last_number_ = 0;
  std::int64_t stops_sent_ = 0, stopped_ = 0;

  std::vector<FrameSample> batch_;
  std::optional<std::int64_t> next_seq_;
  std::optional<double> device_time_s_;  // of the last sample
  MonoTime device_time_received_;  // when that sample came
};

}  // namespace lcrig::frame_link
