// SPDX-License-Identifier: Apache-2.0
#include "drivers/fd_transport.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <cstring>

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
constexpr auto kAsResult = asio::as_tuple(asio::use_awaitable);

// What the kernel says when the other side of a tty, pty or socket went away.
bool is_gone(const boost::system::error_code& ec) {
  return ec == asio::error::eof || ec == asio::error::broken_pipe ||
         ec == asio::error::connection_reset || ec == asio::error::bad_descriptor ||
         ec == asio::error::operation_aborted || ec.value() == EIO || ec.value() == ENXIO ||
         ec.value() == ENODEV;
}

tl::unexpected<Error> failed(const std::string& name, std::string_view what,
                             const boost::system::error_code& ec) {
  if (is_gone(ec)) return fail(Errc::disconnected, "{}: the port went away ({})", name, what);
  return fail(Errc::io, "{}: {}: {}", name, what, ec.message());
}

}  // namespace

FdTransport::FdTransport(asio::any_io_executor executor, Clock& clock, int fd, std::string name,
                         std::function<void(int)> closer)
    : descriptor_(std::move(executor), fd),
      clock_(clock),
      name_(std::move(name)),
      closer_(std::move(closer)) {
  descriptor_.non_blocking(true);
}

FdTransport::~FdTransport() {
  close();
}

void FdTransport::close() {
  if (!descriptor_.is_open()) return;
  const int fd = descriptor_.release();
  if (closer_) {
    closer_(fd);
  } else {
    ::close(fd);
  }
}

Task<Result<std::size_t>> FdTransport::read_some(std::span<char> buffer, MonoTime deadline) {
  if (!descriptor_.is_open()) co_return fail(Errc::disconnected, "{}: the port is closed", name_);
  const auto into = asio::buffer(buffer.data(), buffer.size());
  auto r = co_await (descriptor_.async_read_some(into, kAsResult) || clock_.wait_until(deadline));
  if (r.index() == 1) co_return fail(Errc::no_reply, "{}: nothing received in time", name_);
  const auto& [ec, n] = std::get<0>(r);
  if (ec) co_return failed(name_, "read", ec);
  co_return n;
}

Task<Result<>> FdTransport::write_all(std::string_view bytes, MonoTime deadline) {
  if (!descriptor_.is_open()) co_return fail(Errc::disconnected, "{}: the port is closed", name_);
  const auto from = asio::buffer(bytes.data(), bytes.size());
  auto r =
      co_await (asio::async_write(descriptor_, from, kAsResult) || clock_.wait_until(deadline));
  if (r.index() == 1) co_return fail(Errc::io, "{}: the other side takes no bytes", name_);
  const auto& ec = std::get<0>(std::get<0>(r));
  if (ec) co_return failed(name_, "write", ec);
  co_return Result<>();
}

Result<TransportPair> make_socketpair(asio::any_io_executor executor, Clock& clock,
                                      const std::string& name) {
  int fds[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fds) != 0) {
    return fail(Errc::io, "{}: socketpair: {}", name, std::strerror(errno));
  }
  TransportPair pair;
  pair.near = std::make_unique<FdTransport>(executor, clock, fds[0], name);
  pair.far = std::make_unique<FdTransport>(executor, clock, fds[1], name + " (far end)");
  return pair;
}

}  // namespace lcrig
