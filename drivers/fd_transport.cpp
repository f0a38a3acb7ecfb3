// SPDX-License-Identifier: Apache-2.0
#include "drivers/fd_transport.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>
#include <cerrno>
#include <thread>
#include <tuple>
#include <utility>

#include "base/as_result.hpp"
#include "base/either.hpp"

namespace lcrig {

namespace {

// The errors that the kernel reports when the other side of a tty, pty or socket went away.
bool is_gone(const boost::system::error_code& ec) {
  return ec == asio::error::eof || ec == asio::error::broken_pipe ||
         ec == asio::error::connection_reset || ec == asio::error::bad_descriptor ||
         ec == asio::error::operation_aborted || ec.value() == EIO || ec.value() == ENXIO ||
         ec.value() == ENODEV;
}

boost::system::error_code last_error(bool end_of_file) {
  if (end_of_file) return asio::error::eof;
  return {errno, boost::system::system_category()};
}

bool is_socket(int fd) {
  struct stat s{};
  return ::fstat(fd, &s) == 0 && S_ISSOCK(s.st_mode);
}

}  // namespace

FdTransport::FdTransport(asio::any_io_executor executor, Clock& clock, int fd, std::string name,
                         std::function<void(int)> closer)
    : descriptor_(std::move(executor), fd),
      clock_(clock),
      name_(std::move(name)),
      closer_(std::move(closer)),
      is_socket_(is_socket(fd)) {
  descriptor_.non_blocking(true);
}

FdTransport::~FdTransport() {
  close();
}

// A port that went away is closed on another thread and not awaited, because its driver may take
// seconds to close it. Bytes still in it are lost anyway.
void FdTransport::close() {
  if (!descriptor_.is_open()) return;
  const int fd = descriptor_.release();
  if (!closer_) {
    ::close(fd);
  } else if (is_gone_) {
    std::thread([closer = std::move(closer_), fd] { closer(fd); }).detach();
  } else {
    closer_(fd);
  }
}

tl::unexpected<Error> FdTransport::failed(std::string_view what,
                                          const boost::system::error_code& ec) {
  is_gone_ = is_gone(ec);
  if (is_gone_) return fail(Errc::disconnected, "{}: the port went away ({})", name_, what);
  return fail(Errc::io, "{}: {}: {}", name_, what, ec.message());
}

Result<std::size_t> FdTransport::read_now(std::span<char> buffer) {
  const ssize_t n = ::read(descriptor_.native_handle(), buffer.data(), buffer.size());
  if (n > 0) return static_cast<std::size_t>(n);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  return failed("read", last_error(n == 0));
}

Task<Result<std::size_t>> FdTransport::read_some(std::span<char> buffer, MonoTime deadline) {
  if (!descriptor_.is_open()) co_return fail(Errc::disconnected, "{}: the port is closed", name_);
  // Reads bytes that have arrived directly, because going through the reactor costs more than the
  // read itself. Every 64th read still goes through the reactor, so that a peer that floods the
  // line cannot starve the other coroutines of this thread.
  const bool only_look = deadline <= clock_.now();
  if (only_look || ++eager_reads_ % 64 != 0) {
    auto got = read_now(buffer);
    if (!got || *got > 0) co_return got;
    if (only_look) co_return fail(Errc::no_reply, "{}: nothing received in time", name_);
  }
  const auto into = asio::buffer(buffer.data(), buffer.size());
  boost::system::error_code ec;
  std::size_t n = 0;
  if (deadline == MonoTime::max()) {
    auto r = co_await descriptor_.async_read_some(into, kAsResult);
    std::tie(ec, n) = r;
  } else {
    auto r =
        co_await either(descriptor_.async_read_some(into, kAsResult), clock_.wait_until(deadline));
    if (r.index() == 1) co_return fail(Errc::no_reply, "{}: nothing received in time", name_);
    std::tie(ec, n) = std::get<0>(r);
  }
  if (ec) co_return failed("read", ec);
  co_return n;
}

// Writes what the kernel accepts and removes it from `bytes`. Sockets use send(), because write()
// raises SIGPIPE when the other end is closed.
Result<> FdTransport::write_now(std::string_view& bytes) {
  const int fd = descriptor_.native_handle();
  ssize_t n = is_socket_ ? ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT)
                         : ::write(fd, bytes.data(), bytes.size());
  if (n < 0 && errno != EAGAIN && errno != EINTR) return failed("write", last_error(false));
  if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
  return {};
}

Task<Result<>> FdTransport::write_all(std::string_view bytes, MonoTime deadline) {
  while (true) {
    if (!descriptor_.is_open()) co_return fail(Errc::disconnected, "{}: the port is closed", name_);
    auto written = write_now(bytes);
    if (!written || bytes.empty()) co_return written;
    const auto writable = asio::posix::stream_descriptor::wait_write;
    auto r =
        co_await either(descriptor_.async_wait(writable, kAsResult), clock_.wait_until(deadline));
    if (r.index() == 1) co_return fail(Errc::io, "{}: the other side takes no bytes", name_);
    const auto& ec = std::get<0>(std::get<0>(r));
    if (ec) co_return failed("write", ec);
  }
}

Result<TransportPair> make_socketpair(asio::any_io_executor executor, Clock& clock,
                                      const std::string& name) {
  int fds[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fds) != 0) {
    return fail(Errc::io, "{}: socketpair: {}", name, std::strerror(errno));
  }
  auto near = std::make_unique<FdTransport>(executor, clock, fds[0], name);
  auto far = std::make_unique<FdTransport>(executor, clock, fds[1], name + " (far end)");
  return TransportPair{.near = std::move(near), .far = std::move(far)};
}

}  // namespace lcrig
