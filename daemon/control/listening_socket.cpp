// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/listening_socket.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace lcrig {

namespace {

constexpr mode_t kSocketMode = 0660;  // owner and group lcrig, because whoever may write may move
                                      // the frame

// Errno of a connection to `path`; 0: somebody listens. Does not wait for one whose queue is full.
int try_to_connect(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return errno;
  const bool made = ::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  const int error = made || errno == EAGAIN ? 0 : errno;
  ::close(fd);
  return error;
}

// Removes the socket of a daemon that is gone. Keeps a file at `path` that is not a socket.
Result<> clear_stale_socket(const std::string& path) {
  struct stat info{};
  if (::lstat(path.c_str(), &info) != 0) return {};
  if (!S_ISSOCK(info.st_mode)) {
    return fail(Errc::io, "control: {} exists and is no socket; move it away or use --socket",
                path);
  }
  const int error = try_to_connect(path);
  if (error == 0) {
    return fail(Errc::busy,
                "control: another lcrigd answers at {}; stop it first (systemctl stop lcrigd) or "
                "use --socket",
                path);
  }
  if (error == ENOENT) return {};
  if (error != ECONNREFUSED) {
    return fail(Errc::io, "control: {}: {}", path, std::strerror(error));
  }
  if (::unlink(path.c_str()) != 0) {
    return fail(Errc::io, "control: cannot remove the stale socket {}: {}", path,
                std::strerror(errno));
  }
  return {};
}

}  // namespace

ListeningSocket::ListeningSocket(asio::any_io_executor executor, std::string path)
    : path_(std::move(path)), acceptor_(std::move(executor)) {}

ListeningSocket::~ListeningSocket() {
  close();
}

Result<std::shared_ptr<ListeningSocket>> ListeningSocket::open(asio::any_io_executor executor,
                                                               const std::string& path) {
  if (path.size() >= sizeof(sockaddr_un::sun_path)) {
    return fail(Errc::invalid_request, "control: {}: a socket path has at most {} characters", path,
                sizeof(sockaddr_un::sun_path) - 1);
  }
  if (auto clear = clear_stale_socket(path); !clear) return fail(clear.error());
  std::shared_ptr<ListeningSocket> made(new ListeningSocket(std::move(executor), path));
  if (auto bound = made->bind(); !bound) return fail(bound.error());
  return made;
}

Result<> ListeningSocket::bind() {
  boost::system::error_code ec;
  acceptor_.open(asio::local::stream_protocol(), ec);
  if (!ec) acceptor_.bind(asio::local::stream_protocol::endpoint(path_), ec);
  if (ec) return fail(Errc::io, "control: cannot create {}: {}", path_, ec.message());
  struct stat info{};
  if (::lstat(path_.c_str(), &info) == 0) {
    device_ = info.st_dev;
    inode_ = info.st_ino;
  }
  // Nobody can connect before listen(), so the mode is set for the first client already.
  if (::chmod(path_.c_str(), kSocketMode) != 0) {
    return fail(Errc::io, "control: chmod {}: {}", path_, std::strerror(errno));
  }
  acceptor_.listen(asio::socket_base::max_listen_connections, ec);
  if (ec) return fail(Errc::io, "control: cannot listen at {}: {}", path_, ec.message());
  acceptor_.native_non_blocking(true, ec);
  if (ec) return fail(Errc::io, "control: {}: {}", path_, ec.message());
  return {};
}

Result<> ListeningSocket::is_found() const {
  struct stat info{};
  if (::lstat(path_.c_str(), &info) != 0) {
    if (errno == ENOENT) return fail(Errc::io, "{} was deleted", path_);
    return fail(Errc::io, "{} cannot be reached: {}", path_, std::strerror(errno));
  }
  // The number of our file is not used again while the socket is open.
  if (info.st_dev == device_ && info.st_ino == inode_) return {};
  return fail(Errc::busy, "{} was replaced by another file", path_);
}

void ListeningSocket::close() {
  if (!acceptor_.is_open()) return;
  if (inode_ != 0 && is_found()) ::unlink(path_.c_str());
  boost::system::error_code ignored;
  acceptor_.close(ignored);
}

}  // namespace lcrig
