// SPDX-License-Identifier: Apache-2.0
// The control socket: JSON-RPC 2.0 over a Unix stream socket. Owned by App. Runs on the io_context
// thread.
#pragma once

#include <boost/asio/local/stream_protocol.hpp>
#include <memory>
#include <set>
#include <string>

#include "base/clock.hpp"
#include "base/condition.hpp"
#include "daemon/control/session.hpp"
#include "daemon/control/user_names.hpp"

namespace lcrig {

// `clock` and `handler` must outlive it. Before destroying it, call `close` and let the io_context
// run until that has returned.
class ControlServer {
 public:
  ControlServer(asio::any_io_executor executor, Clock& clock, ControlHandler& handler,
                ControlOptions options = ControlOptions());
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  // Listens at `path` with mode 0660. Replaces a socket file that nobody answers. Errors: busy
  // (another daemon answers), io, invalid_request (path too long for a socket).
  Result<> listen(const std::string& path);

  // Send to every client that called `watch`. Never block: a client that does not read first misses
  // status messages and finally loses its connection.
  void publish_status(const RunStatus& status);
  void publish_event(const RunEventNote& note);
  void publish_run_ended(const RunOutcome& ended);
  void publish_queue(const QueueStatus& queue);

  // Name of a user (UserNames::find). While nobody listens, peers come through no socket and state
  // their name themselves.
  Task<std::string> user_name(const PeerCredentials& peer, Duration patience);

  bool is_listening() const { return listening_; }  // stays true after closing
  bool watched() const;  // lets callers skip the encoding when nobody watches
  std::size_t clients() const { return sessions_->size(); }
  std::size_t waiting_bytes() const;  // bytes that wait to be sent, for all clients
  std::size_t held_bytes() const;  // bytes held of received lines
  // Accepts no new clients and calls, sends what is queued, and closes, within `grace`.
  Task<> close(Duration grace);

 private:
  using Protocol = asio::local::stream_protocol;
  using Sessions = std::set<std::shared_ptr<ControlSession>>;

  Task<> accept_loop();
  void admit(Protocol::socket socket);
  void publish(const std::string& line);
  void remove_socket_file();

  asio::any_io_executor executor_;
  Clock& clock_;
  ControlHandler& handler_;
  ControlOptions options_;
  std::shared_ptr<ControlAllowance> allowance_;
  std::shared_ptr<Condition> left_;  // notified when a session ends; shared like the sessions
  UserNames names_;
  Protocol::acceptor acceptor_;
  std::string path_;
  std::uint64_t device_ = 0, inode_ = 0;  // identify our socket file
  bool listening_ = false;
  // Shared with the sessions' completion handlers, which may run after this object is destroyed.
  std::shared_ptr<Sessions> sessions_ = std::make_shared<Sessions>();
};

}  // namespace lcrig
