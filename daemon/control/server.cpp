// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/server.hpp"

#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/as_result.hpp"
#include "base/spawn.hpp"

namespace lcrig {

namespace {

constexpr mode_t kSocketMode = 0660;  // owner and group lcrig, because whoever may write may move
                                      // the frame

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

// Removes the socket of a daemon that is gone. Keeps a file at `path` that is not a socket.
Result<> clear_stale_socket(asio::any_io_executor executor, const std::string& path) {
  struct stat info{};
  if (::lstat(path.c_str(), &info) != 0) return {};
  if (!S_ISSOCK(info.st_mode)) {
    return fail(Errc::io, "control: {} exists and is no socket; move it away or use --socket",
                path);
  }
  boost::system::error_code ec;
  asio::local::stream_protocol::socket probe(std::move(executor));
  probe.connect(path, ec);
  if (!ec) {
    return fail(Errc::busy,
                "control: another lcrigd answers at {}; stop it first (systemctl stop lcrigd) or "
                "use --socket",
                path);
  }
  if (ec != asio::error::connection_refused) {
    return fail(Errc::io, "control: {}: {}", path, ec.message());
  }
  if (::unlink(path.c_str()) != 0) {
    return fail(Errc::io, "control: cannot remove the stale socket {}: {}", path,
                std::strerror(errno));
  }
  return {};
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
      names_(executor, clock, options.user_name),
      acceptor_(executor) {}

ControlServer::~ControlServer() {
  for (const auto& session : *sessions_) session->close();
  remove_socket_file();
}

void ControlServer::remove_socket_file() {
  if (path_.empty()) return;
  struct stat info{};
  // Somebody may have replaced our socket file.
  if (::lstat(path_.c_str(), &info) == 0 && info.st_dev == device_ && info.st_ino == inode_) {
    ::unlink(path_.c_str());
  }
  path_.clear();
}

Result<> ControlServer::listen(const std::string& path) {
  if (path.size() >= sizeof(sockaddr_un::sun_path)) {
    return fail(Errc::invalid_request, "control: {}: a socket path has at most {} characters", path,
                sizeof(sockaddr_un::sun_path) - 1);
  }
  if (auto clear = clear_stale_socket(executor_, path); !clear) return clear;
  boost::system::error_code ec;
  acceptor_.open(Protocol(), ec);
  if (!ec) acceptor_.bind(Protocol::endpoint(path), ec);
  if (ec) return fail(Errc::io, "control: cannot create {}: {}", path, ec.message());
  path_ = path;
  struct stat info{};
  if (::lstat(path.c_str(), &info) == 0) {
    device_ = info.st_dev;
    inode_ = info.st_ino;
  }
  // Nobody can connect before listen(), so the mode is set for the first client already.
  if (::chmod(path.c_str(), kSocketMode) != 0) {
    return fail(Errc::io, "control: chmod {}: {}", path, std::strerror(errno));
  }
  acceptor_.listen(asio::socket_base::max_listen_connections, ec);
  if (ec) return fail(Errc::io, "control: cannot listen at {}: {}", path, ec.message());
  listening_ = true;
  spawn(executor_, accept_loop());
  return {};
}

Task<> ControlServer::accept_loop() {
  while (acceptor_.is_open()) {
    auto r = co_await acceptor_.async_accept(kAsResult);
    auto& [ec, socket] = r;
    if (ec == asio::error::operation_aborted) co_return;  // closed; `this` may be gone
    if (!ec) {
      admit(std::move(socket));
      continue;
    }
    // Out of file descriptors: existing clients stay, new ones wait in the backlog.
    spdlog::error("control: accept: {}", ec.message());
    co_await clock_.wait_for(std::chrono::milliseconds(200));
  }
}

void ControlServer::admit(Protocol::socket socket) {
  auto peer = credentials_of(socket.native_handle());
  if (!peer) {
    spdlog::error("{}", peer.error().what);
    return;
  }
  names_.look_up(peer->uid);
  peer->user = names_.known(peer->uid);
  auto session = std::make_shared<ControlSession>(std::move(socket), clock_, handler_,
                                                  std::move(*peer), options_, allowance_);
  if (sessions_->size() >= options_.max_clients) {
    session->send(error_line(
        nullptr, RpcError(rpc_code::kTooManyClients,
                          fmt::format("{} clients are connected already", sessions_->size()),
                          "close one of them, then try again")));
    session->finish();
  }
  sessions_->insert(session);
  asio::co_spawn(executor_, session->run(),
                 [session, sessions = sessions_, left = left_](const std::exception_ptr& error) {
                   sessions->erase(session);
                   left->notify_all();
                   if (error) std::rethrow_exception(error);  // a bug: leaves io_context::run
                 });
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
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  remove_socket_file();
  for (const auto& session : *sessions_) session->finish();
  const MonoTime end = clock_.now() + grace;
  const auto all_left = [this] { return sessions_->empty(); };
  co_await left_->wait(all_left, end);
  for (const auto& session : *sessions_) session->close();
  co_await left_->wait(all_left);
}

}  // namespace lcrig
