// SPDX-License-Identifier: Apache-2.0
// The control socket: JSON-RPC 2.0 over a Unix stream socket. App owns it. Runs on the io_context
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

// `clock` and `handler` outlive it. Call `close` and let the io_context run until it returned
// before destroying it.
class ControlServer {
 public:
  ControlServer(asio::any_io_executor executor, Clock& clock, ControlHandler& handler,
                ControlOptions options = ControlOptions());
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  // Listens at `path`, mode 0660. A socket file that nobody answers is replaced. Errors: busy
  // (another daemon answers), io, invalid_request (path too long for a socket).
  Result<> listen(const std::string& path);

  // To everybody who called `watch`. Never block; a client that does not read loses status
  // messages first and its connection at last.
  void publish_status(const RunStatus& status);
  void publish_event(const RunEventNote& note);
  void publish_run_ended(const RunOutcome& ended);
  void publish_queue(const QueueStatus& queue);

  // Name of a user (UserNames::find). While nobody listens a peer is as it calls itself: it came
  // through no socket.
  Task<std::string> user_name(const PeerCredentials& peer, Duration patience);

  bool is_listening() const { return listening_; }  // or did
  bool watched() const;  // else nobody pays for encoding
  std::size_t clients() const { return sessions_->size(); }
  std::size_t waiting_bytes() const;  // to be sent, of all clients
  std::size_t held_bytes() const;  // of what they sent
  // Takes no new clients and no new calls, sends what is queued, closes. At most `grace`.
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
  std::shared_ptr<Condition> left_;  // a session did; shared as they are
  UserNames names_;
  Protocol::acceptor acceptor_;
  std::string path_;
  std::uint64_t device_ = 0, inode_ = 0;  // of our socket file
  bool listening_ = false;
  // Shared with the completion handlers of the sessions, which may run after a destructor.
  std::shared_ptr<Sessions> sessions_ = std::make_shared<Sessions>();
};

}  // namespace lcrig
