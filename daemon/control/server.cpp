// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/server.hpp"

#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/as_result.hpp"
#include "base/spawn.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// Clients that are accepted before the instruments get their turn. Several such turns fit into the
// reserve, so that a call which came with its connection is read before its place is taken.
constexpr std::size_t kAcceptAtOnce = 16;
constexpr Duration kLookInterval = 1s;

Result<PeerCredentials> credentials_of(int fd) {
  ucred raw{};
  socklen_t size = sizeof raw;
  if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &raw, &size) != 0) {
    return fail(Errc::io, "control: SO_PEERCRED: {}", std::strerror(errno));
  }
  PeerCredentials peer;
  peer.uid = raw.uid;
  peer.pid = raw.pid;
  return peer;
}

// A client that is closed because another one needs its place gets this before.
std::string dismissal(const std::string& why) {
  return error_line(nullptr, RpcError(rpc_code::kTooManyClients, why,
                                      "connect again; idle connections are closed first"));
}

// Whether the client has gone without a word. Asked before anything is made for it, because a
// flood of such connections must cost little.
bool has_left(int fd) {
  char byte = 0;
  return ::recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

std::vector<ControlPlace> places_of(const std::vector<std::shared_ptr<ControlSession>>& sessions) {
  std::vector<ControlPlace> out;
  out.reserve(sessions.size());
  for (const auto& session : sessions) out.push_back(session->place());
  return out;
}

bool lacks_descriptors(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

}  // namespace

ControlServer::ControlServer(asio::any_io_executor executor, Clock& clock, ControlHandler& handler,
                             ControlOptions options)
    : executor_(executor),
      clock_(clock),
      handler_(handler),
      options_(options),
      allowance_(std::make_shared<ControlAllowance>(options.long_bytes_per_s,
                                                    options.max_all_call_bytes, clock.now())),
      left_(std::make_shared<Condition>(clock)),
      names_(executor, clock, options.user_name) {}

ControlServer::~ControlServer() {
  *closed_ = true;
  left_->notify_all();
  if (socket_) socket_->close();
  for (const auto& session : *sessions_) session->close();
}

Result<> ControlServer::listen(const std::string& path) {
  if (auto opened = keep(ListeningSocket::open(executor_, path), socket_); !opened) return opened;
  path_ = path;
  listening_ = true;
  spawn(executor_, accept_loop(socket_));
  spawn(executor_, look_after());
  return {};
}

// A flood of connections gets at most half of this thread's time: after each turn the loop waits as
// long as the turn, and what it caused, have taken.
Task<> ControlServer::accept_loop(std::shared_ptr<ListeningSocket> socket) {
  const auto closed = closed_;
  for (;;) {
    auto r = co_await socket->acceptor().async_wait(asio::socket_base::wait_read, kAsResult);
    const auto& [ec] = r;
    if (*closed || ec) co_return;  // closed; `this` may be gone
    const MonoTime begin = clock_.now();
    const bool has_room = take_waiting(*socket, kAcceptAtOnce);
    co_await asio::post(executor_, kAsResult);
    if (*closed) co_return;
    const Duration taken = std::min<Duration>(clock_.now() - begin, 10ms);
    const Duration pause = has_room ? taken : 200ms;
    co_await clock_.wait_for(pause);
    if (*closed) co_return;
  }
}

bool ControlServer::take_waiting(ListeningSocket& socket, std::size_t most) {
  for (std::size_t i = 0; i < most; ++i) {
    const int fd = ::accept4(socket.acceptor().native_handle(), nullptr, nullptr, SOCK_CLOEXEC);
    if (fd >= 0) {
      admit(fd);
      continue;
    }
    if (errno == EAGAIN || errno == EBADF) return true;
    if (!lacks_descriptors(errno)) continue;  // that client is gone
    tell_full(fmt::format("accept: {}", std::strerror(errno)));
    if (!vacate_reserve() && !make_room("lcrigd has no file descriptor left")) return false;
  }
  return true;
}

void ControlServer::admit(int fd) {
  auto peer = credentials_of(fd);
  ControlSession::Socket socket(executor_);
  boost::system::error_code ec;
  if (peer && !has_left(fd)) socket.assign(asio::local::stream_protocol(), fd, ec);
  if (!socket.is_open()) {
    ::close(fd);
    if (!peer) spdlog::error("{}", peer.error().what);
    return;
  }
  names_.look_up(peer->uid);
  peer->user = names_.known(peer->uid);
  const bool full = seated(ControlSeat::all).size() >= options_.max_clients;
  const auto why =
      fmt::format("all {} places were taken, and this client was idle", options_.max_clients);
  const auto seat = full && !make_room(why.c_str()) ? ControlSeat::urgent : ControlSeat::all;
  if (seat == ControlSeat::urgent && seated(seat).size() >= options_.reserve) vacate_reserve();
  auto session = std::make_shared<ControlSession>(std::move(socket), clock_, handler_,
                                                  std::move(*peer), options_, allowance_, seat);
  sessions_->insert(session);
  asio::co_spawn(executor_, session->run(),
                 [session, sessions = sessions_, left = left_](const std::exception_ptr& error) {
                   sessions->erase(session);
                   left->notify_all();
                   if (error) std::rethrow_exception(error);  // a bug: leaves io_context::run
                 });
}

std::vector<ControlServer::Session> ControlServer::seated(ControlSeat seat) const {
  std::vector<Session> out;
  out.reserve(sessions_->size());
  for (const auto& session : *sessions_) {
    if (session->seat() == seat && !session->closed()) out.push_back(session);
  }
  return out;
}

// True: a client that was idle has left for another one.
bool ControlServer::make_room(const char* why) {
  const auto clients = seated(ControlSeat::all);
  const auto idle = longest_idle(places_of(clients), clock_.now(), options_.idle);
  if (!idle) {
    tell_full(
        fmt::format("{} clients are connected, none of them idle; others may only stop the run",
                    clients.size()));
    return false;
  }
  clients[*idle]->dismiss(dismissal(why));
  return true;
}

bool ControlServer::vacate_reserve() {
  const auto clients = seated(ControlSeat::urgent);
  if (clients.empty()) return false;
  clients[greediest(places_of(clients))]->dismiss(
      dismissal("the places for stops were needed by another client"));
  return true;
}

void ControlServer::close_quiet_reserve() {
  const MonoTime now = clock_.now();
  for (const auto& session : seated(ControlSeat::urgent)) {
    if (now - session->place().quiet_since < options_.reserve_patience) continue;
    session->dismiss(dismissal(
        fmt::format("{} clients are connected already, and this one asked for nothing in {:.3g} s",
                    options_.max_clients, to_seconds(options_.reserve_patience))));
  }
}

// At most once a minute: a flood would fill the journal.
void ControlServer::tell_full(const std::string& words) {
  const MonoTime now = clock_.now();
  if (told_full_ != MonoTime() && now - told_full_ < 1min) return;
  told_full_ = now;
  spdlog::warn("control: {}", words);
}

// Closes who keeps a place of the reserve for nothing, and brings back a socket file that is gone.
Task<> ControlServer::look_after() {
  const auto closed = closed_;
  const auto left = left_;
  Clock& clock = clock_;
  const auto is_closed = [&closed] { return *closed; };
  for (;;) {
    const MonoTime next = clock.now() + kLookInterval;
    const bool over = co_await left->wait(is_closed, next);
    if (over) co_return;
    close_quiet_reserve();
    keep_socket();
  }
}

// A file that another program put there is replaced only if nobody answers behind it, and not at
// the first look: a daemon that starts listens a moment after it has made its file.
void ControlServer::keep_socket() {
  auto found = socket_->is_found();
  if (found) return set_trouble("");
  const bool is_new = trouble_.empty();
  set_trouble(found.error().what);
  if (is_new && found.error().code == Errc::busy) return;
  auto made = ListeningSocket::open(executor_, path_);
  if (!made) return;
  // Who connected before the file was gone is served.
  take_waiting(*socket_, SOMAXCONN);
  socket_->close();
  socket_ = std::move(*made);
  spawn(executor_, accept_loop(socket_));
  set_trouble("");
}

void ControlServer::set_trouble(const std::string& words) {
  if (words == trouble_) return;
  const bool is_over = words.empty();
  trouble_ = words;
  if (is_over) return spdlog::warn("control: {} is there again", path_);
  spdlog::critical("control: no client finds the daemon any more: {}; to stop a run: {}", words,
                   kStopBySignal);
}

Task<std::string> ControlServer::user_name(const PeerCredentials& peer, Duration patience) {
  if (!listening_) co_return peer.user;
  co_return co_await names_.find(peer.uid, patience);
}

std::size_t ControlServer::waiting_bytes() const {
  std::size_t sum = 0;
  for (const auto& session : *sessions_) sum += session->waiting_bytes();
  return sum;
}

std::size_t ControlServer::held_bytes() const {
  std::size_t sum = 0;
  for (const auto& session : *sessions_) sum += session->held_bytes();
  return sum;
}

bool ControlServer::watched() const {
  return std::any_of(sessions_->begin(), sessions_->end(),
                     [](const auto& session) { return session->watching(); });
}

void ControlServer::publish(const std::string& line) {
  for (const auto& session : *sessions_) {
    if (session->watching()) session->send(line);
  }
}

void ControlServer::publish_status(const RunStatus& status) {
  if (!watched()) return;
  const auto line = notification_line("status", to_json(status));
  for (const auto& session : *sessions_) {
    if (session->watching()) session->send_status(line);
  }
}

void ControlServer::publish_event(const RunEventNote& note) {
  if (!watched()) return;
  publish(notification_line("event", to_json(note)));
}

void ControlServer::publish_run_ended(const RunOutcome& ended) {
  for (const auto& session : *sessions_) session->forget_status();
  if (watched()) publish(notification_line("run_ended", to_json(ended)));
}

void ControlServer::publish_queue(const QueueStatus& queue) {
  if (watched()) publish(notification_line("queue", to_json(queue)));
}

Task<> ControlServer::close(Duration grace) {
  *closed_ = true;
  if (socket_) socket_->close();
  left_->notify_all();
  for (const auto& session : *sessions_) session->finish();
  const MonoTime end = clock_.now() + grace;
  const auto all_left = [this] { return sessions_->empty(); };
  co_await left_->wait(all_left, end);
  for (const auto& session : *sessions_) session->close();
  co_await left_->wait(all_left);
}

}  // namespace lcrig
