// SPDX-License-Identifier: Apache-2.0
// A transport over any stream file descriptor: tty, pty, socketpair, connected TCP socket. Used by
// serial_transport, tcp_transport, lcrig-sim and runs simulated in real time.
#pragma once

#include <boost/asio/posix/stream_descriptor.hpp>
#include <functional>

#include "base/clock.hpp"
#include "drivers/transport.hpp"

namespace lcrig {

class FdTransport final : public Transport {
 public:
  // Takes ownership of `fd`. `closer` closes the descriptor after Asio has released it, for ports
  // that need more than ::close, the default. A port that went away is closed on a thread of its
  // own.
  FdTransport(asio::any_io_executor executor, Clock& clock, int fd, std::string name,
              std::function<void(int)> closer = {});
  ~FdTransport() override;

  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override;
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override;
  void close() override;
  const std::string& name() const override { return name_; }

 private:
  Result<std::size_t> read_now(std::span<char> buffer);  // 0: no bytes yet
  Result<> write_now(std::string_view& bytes);
  tl::unexpected<Error> failed(std::string_view what, const boost::system::error_code& ec);

  asio::posix::stream_descriptor descriptor_;
  Clock& clock_;
  std::string name_;
  std::function<void(int)> closer_;
  bool is_socket_;
  bool is_gone_ = false;
  unsigned eager_reads_ = 0;
};

Result<TransportPair> make_socketpair(asio::any_io_executor executor, Clock& clock,
                                      const std::string& name);

}  // namespace lcrig
