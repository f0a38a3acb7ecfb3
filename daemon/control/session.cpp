// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/session.hpp"

#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <vector>

#include "base/as_result.hpp"
#include "base/either.hpp"
#include "daemon/control/audit.hpp"
#include "daemon/control/dispatch.hpp"
#include "daemon/control/methods.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kChunk = 16384;
// Lines that are read from one client before the instruments and the other clients get their turn.
constexpr int kLinesAtOnce = 16;
// A longer line is no stop, and never treated as one.
constexpr std::size_t kUrgentLine = 4096;
// A client of the reserve calls once or twice.
constexpr double kUrgentBurst = 8, kUrgentCalls_per_s = 10;

}  // namespace

ControlSession::ControlSession(Socket socket, Clock& clock, ControlHandler& handler,
                               PeerCredentials peer, ControlOptions options,
                               std::shared_ptr<ControlAllowance> allowance, ControlSeat seat)
    : socket_(std::move(socket)),
      clock_(clock),
      handler_(handler),
      peer_(std::move(peer)),
      options_(options),
      allowance_(std::move(allowance)),
      tokens_(options.burst),
      refilled_(clock.now()),
      came_(refilled_),
      quiet_since_(refilled_),
      seat_(seat),
      wake_(socket_.get_executor(), 1) {
  if (seat_ == ControlSeat::all) allowance_->come();
}

ControlSession::~ControlSession() {
  if (seat_ == ControlSeat::all) allowance_->go();
}

ControlPlace ControlSession::place() const {
  ControlPlace out;
  out.uid = peer_.uid;
  out.pid = peer_.pid;
  out.came = came_;
  out.quiet_since = quiet_since_;
  out.busy = watching_ || !idle();
  return out;
}

void ControlSession::dismiss(const std::string& line) {
  if (closed_) return;
  ::send(socket_.native_handle(), line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  close();
}

Task<> ControlSession::run() {
  const auto self = shared_from_this();
  // The connection ends with the writer, which outlives the reader until all is answered.
  co_await both(read_loop(), write_loop());
  close();
}

void ControlSession::close() {
  closed_ = true;
  boost::system::error_code ignored;
  socket_.close(ignored);
  wake();
}

void ControlSession::finish() {
  finishing_ = true;
  boost::system::error_code ignored;
  // The reader gets end of file; the peer can still receive.
  socket_.shutdown(Socket::shutdown_receive, ignored);
  wake();
}

void ControlSession::send(std::string line) {
  if (closed_) return;
  queued_bytes_ += line.size();
  if (queued_bytes_ > options_.max_queue_bytes) {
    spdlog::warn("control: {} does not read its answers; connection cut", peer_words(peer_));
    return close();
  }
  queue_.push_back(std::move(line));
  wake();
}

void ControlSession::send_status(const std::string& line) {
  if (closed_) return;
  status_ = line;
  wake();
}

Task<> ControlSession::read_loop() {
  std::vector<char> chunk(kChunk);
  while (!closed_ && !finishing_) {
    auto r = co_await socket_.async_read_some(asio::buffer(chunk), kAsResult);
    const auto& [ec, n] = r;
    if (ec) break;  // end of file; an incomplete message is dropped
    if (seat_ == ControlSeat::all) quiet_since_ = clock_.now();
    // Reserves once, because doubling could take twice the size of the longest line.
    if (in_.size() + n > 4 * kChunk) in_.reserve(line_limit() + kChunk);
    in_.append(chunk.data(), n);
    const bool more = co_await take_lines();
    if (!more) break;
  }
  finishing_ = true;
  wake();
}

Task<bool> ControlSession::take_lines() {
  std::size_t begin = 0;
  int lines = 0;
  for (;;) {
    const auto end = in_.find('\n', std::max(begin, scanned_));
    if (end == std::string::npos) break;
    if (end - begin > line_limit()) break;
    co_await slow_down(end - begin);
    if (++lines % kLinesAtOnce == 0) co_await asio::post(socket_.get_executor(), kAsResult);
    if (closed_ || finishing_) co_return false;
    on_line(std::string_view(in_).substr(begin, end - begin));
    begin = end + 1;
    scanned_ = begin;
  }
  in_.erase(0, begin);
  scanned_ = in_.size();
  if (in_.size() <= line_limit()) co_return true;
  send(error_line(nullptr, RpcError(rpc_code::kLineTooLong,
                                    fmt::format("a line is limited to {} bytes", line_limit()),
                                    "send smaller messages; the connection is closed")));
  co_return false;
}

// A token bucket slows down the reading from this client. Nothing is lost, and other clients do not
// notice.
Task<> ControlSession::slow_down(std::size_t bytes) {
  constexpr double kBytesPerCall = 4096;
  const MonoTime now = clock_.now();
  const bool all = seat_ == ControlSeat::all;
  const double share = allowance_->share();
  const double calls_per_s = all ? options_.calls_per_s * share : kUrgentCalls_per_s;
  const double burst = all ? options_.burst * share : kUrgentBurst;
  tokens_ = std::min(burst, tokens_ + to_seconds(now - refilled_) * calls_per_s);
  refilled_ = now;
  tokens_ -= 1 + static_cast<double>(bytes) / kBytesPerCall;
  if (tokens_ < 0) co_await clock_.wait_for(from_seconds(-tokens_ / calls_per_s));
  // Charged after the first wait. Otherwise clients that waited equally long would all be served at
  // once.
  const Duration others = allowance_->charge(bytes, clock_.now());
  if (others > Duration::zero()) co_await clock_.wait_for(others);
}

std::size_t ControlSession::line_limit() const {
  return seat_ == ControlSeat::all ? kControlLineLimit : kUrgentLine;
}

// A stop has limits of its own, which no other call and no other client uses up.
bool ControlSession::take_call(bool urgent, std::size_t bytes) {
  if (urgent) return urgent_calls_ < options_.max_calls && ++urgent_calls_ > 0;
  if (calls_ >= options_.max_calls || call_bytes_ + bytes > options_.max_call_bytes) return false;
  if (!allowance_->take_call(bytes)) return false;
  ++calls_;
  call_bytes_ += bytes;
  return true;
}

void ControlSession::end_call(bool urgent, std::size_t bytes) {
  quiet_since_ = clock_.now();
  if (urgent) {
    --urgent_calls_;
  } else {
    --calls_;
    call_bytes_ -= bytes;
    allowance_->end_call(bytes);
  }
  wake();
}

void ControlSession::on_line(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (line.find_first_not_of(" \t") == std::string_view::npos) return;
  auto call = parse_control_call(line);
  if (!call) return send(std::move(call.error()));
  const ControlMethod* const method = find_control_method(call->method);
  const bool urgent = method != nullptr && method->urgent && line.size() <= kUrgentLine;
  if (!urgent && seat_ == ControlSeat::urgent) {
    return send(error_line(
        call->id, RpcError(rpc_code::kTooManyClients,
                           fmt::format("{} clients are connected already", options_.max_clients),
                           "this one may only stop the run, hold the queue and "
                           "ask for the status; close another one")));
  }
  if (!take_call(urgent, line.size())) {
    return send(error_line(call->id, RpcError(rpc_code::kTooManyCalls,
                                              "too many calls of this client, or too many bytes "
                                              "of all clients, are under way",
                                              "wait for their answers")));
  }
  quiet_since_ = clock_.now();
  if (method != nullptr && method->watches) watching_ = true;
  asio::co_spawn(
      socket_.get_executor(), answer(std::move(*call)),
      [self = shared_from_this(), urgent, bytes = line.size()](const std::exception_ptr& error) {
        self->end_call(urgent, bytes);
        if (error) std::rethrow_exception(error);  // a bug: leaves io_context::run
      });
}

Task<> ControlSession::answer(ControlCall call) {
  auto line = co_await answer_control_call(handler_, std::move(call), peer_);
  if (line) send(std::move(*line));
}

Task<> ControlSession::write_loop() {
  while (!closed_) {
    if (queue_.empty() && status_) {
      queued_bytes_ += status_->size();
      queue_.push_back(std::move(*status_));
      status_.reset();
    }
    if (queue_.empty()) {
      if (finishing_ && idle()) break;
      co_await wake_.async_receive(kAsResult);
      continue;
    }
    const auto bytes = asio::buffer(queue_.front());
    auto r = co_await either(asio::async_write(socket_, bytes, kAsResult),
                             clock_.wait_for(options_.write_timeout));
    if (r.index() == 1 || std::get<0>(std::get<0>(r))) break;
    queued_bytes_ -= queue_.front().size();
    queue_.pop_front();
    quiet_since_ = clock_.now();
  }
  close();
}

}  // namespace lcrig
