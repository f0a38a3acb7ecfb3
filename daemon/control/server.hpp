// SPDX-License-Identifier: Apache-2.0
// The control socket: JSON-RPC 2.0 over a Unix stream socket. Owned by App. Runs on the io_context
// thread.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/condition.hpp"
#include "daemon/control/listening_socket.hpp"
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
  // (another daemon answers), io, invalid_request (path too long for a socket). A socket file that
  // is deleted or replaced later is made again within seconds, if nobody else answers there.
  Result<> listen(const std::string& path);
  // Why no client can find the socket, in words; empty: they can.
  const std::string& trouble() const { return trouble_; }

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
  using Session = std::shared_ptr<ControlSession>;
  using Sessions = std::set<Session>;

  Task<> accept_loop(std::shared_ptr<ListeningSocket> socket);
  Task<> look_after();
  void keep_socket();
  void set_trouble(const std::string& words);
  // False: the next ones have to wait, because the process has no file descriptor left.
  bool take_waiting(ListeningSocket& socket, std::size_t most);
  void admit(int fd);
  std::vector<Session> seated(ControlSeat seat) const;
  bool make_room(const char* why);
  bool vacate_reserve();
  void tell_full(const std::string& words);
  void close_quiet_reserve();
  void publish(const std::string& line);

  asio::any_io_executor executor_;
  Clock& clock_;
  ControlHandler& handler_;
  ControlOptions options_;
  std::shared_ptr<ControlAllowance> allowance_;
  std::shared_ptr<Condition> left_;  // notified when a session ends; shared like the sessions
  UserNames names_;
  std::string path_, trouble_;
  std::shared_ptr<ListeningSocket> socket_;
  bool listening_ = false;
  MonoTime told_full_;
  // Shared with coroutines and completion handlers, which may run after this object is destroyed.
  std::shared_ptr<Sessions> sessions_ = std::make_shared<Sessions>();
  std::shared_ptr<bool> closed_ = std::make_shared<bool>(false);
};

}  // namespace lcrig
