// SPDX-License-Identifier: Apache-2.0
// One client of the control socket: reads its requests, sends answers, events and status, and
// limits its costs. ControlServer makes one for each connection.
#pragma once

#include <boost/asio/experimental/channel.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "daemon/control/handler.hpp"
#include "daemon/control/limits.hpp"
#include "daemon/control/places.hpp"
#include "daemon/control/user_names.hpp"

namespace lcrig {

struct ControlOptions {
  std::size_t max_clients = 64;
  // Places beyond these, for stops and `status` only. A client keeps one for `reserve_patience`
  // after its last call, and loses it earlier to another one that comes (places.hpp).
  std::size_t reserve = 64;
  Duration reserve_patience = std::chrono::seconds(2);
  // A client that neither watches nor waits for an answer, and has been quiet for so long, gives
  // its place to another one that comes when all are taken.
  Duration idle = std::chrono::seconds(1);
  std::size_t max_calls = 16;  // of one client at the same time
  std::size_t max_call_bytes = std::size_t{4} << 20U;  // bytes of the lines of these calls
  std::size_t max_queue_bytes = std::size_t{1} << 20U;  // bytes of one client that wait to be sent
  Duration write_timeout = std::chrono::seconds(10);  // then a client that does not read is
                                                      // disconnected
  // A client that sends more is read more slowly, down to this rate. With more than eight clients
  // the rate falls to an equal share of that of eight. A line counts as one call for every 4 KiB,
  // because it costs the thread of the instruments as much.
  double calls_per_s = 200;
  double burst = 400;
  // Limits for all clients together: bytes in lines above 4 KiB, and bytes of calls in progress.
  double long_bytes_per_s = 4 << 20U;
  std::size_t max_all_call_bytes = std::size_t{16} << 20U;
  UserNames::Lookup user_name = UserNames::of_system;
};

struct ControlCall;

// What a client may call.
enum class ControlSeat { all, urgent };

// Shared with its calls in progress, which may outlive the client: a run must not depend on whether
// its client stays connected. `handler` and `clock` must outlive it.
class ControlSession : public std::enable_shared_from_this<ControlSession> {
 public:
  using Socket = asio::local::stream_protocol::socket;

  ControlSession(Socket socket, Clock& clock, ControlHandler& handler, PeerCredentials peer,
                 ControlOptions options, std::shared_ptr<ControlAllowance> allowance,
                 ControlSeat seat = ControlSeat::all);
  ~ControlSession();
  ControlSession(const ControlSession&) = delete;
  ControlSession& operator=(const ControlSession&) = delete;

  Task<> run();  // until the client disconnects, is disconnected, or `close`
  // Only the newest status waits, so a slow watcher sees fewer of them.
  void send_status(const std::string& line);
  void send(std::string line);
  // When a run has ended: a status of it that still waits is out of date.
  void forget_status() { status_.reset(); }
  // Reads no more, and ends when everything in progress and queued is answered and sent.
  void finish();
  void close();  // ends at once
  // Ends at once, after as much of `line` as the client takes without waiting.
  void dismiss(const std::string& line);
  bool watching() const { return watching_; }
  bool closed() const { return closed_; }
  ControlSeat seat() const { return seat_; }
  ControlPlace place() const;
  // Memory for received lines: at most one line of the largest size, one chunk of reading, and the
  // calls in progress.
  std::size_t held_bytes() const { return in_.capacity() + call_bytes_; }
  // Bytes that wait to be sent: at most max_queue_bytes and one status.
  std::size_t waiting_bytes() const { return queued_bytes_ + (status_ ? status_->size() : 0); }

 private:
  Task<> read_loop();
  Task<> write_loop();
  Task<bool> take_lines();  // false: end the connection when the queue is sent
  Task<> slow_down(std::size_t bytes);
  std::size_t line_limit() const;
  bool take_call(bool urgent, std::size_t bytes);
  void end_call(bool urgent, std::size_t bytes);
  void on_line(std::string_view line);
  Task<> answer(ControlCall call);
  bool idle() const { return queue_.empty() && !status_ && calls_ == 0 && urgent_calls_ == 0; }
  void wake() { wake_.try_send(boost::system::error_code()); }

  Socket socket_;
  Clock& clock_;
  ControlHandler& handler_;
  PeerCredentials peer_;
  ControlOptions options_;
  std::shared_ptr<ControlAllowance> allowance_;
  std::string in_;
  std::size_t scanned_ = 0;  // bytes of in_ that contain no newline
  std::deque<std::string> queue_;
  std::size_t queued_bytes_ = 0;
  std::optional<std::string> status_;
  std::size_t calls_ = 0, urgent_calls_ = 0, call_bytes_ = 0;  // in progress
  double tokens_;
  MonoTime refilled_, came_, quiet_since_;
  ControlSeat seat_;
  bool watching_ = false, finishing_ = false, closed_ = false;
  asio::experimental::channel<void(boost::system::error_code)> wake_;
};

}  // namespace lcrig
