// SPDX-License-Identifier: Apache-2.0
// The listening end of the control socket, and the file by which clients find it. Knows whether the
// file is still its own, because anybody who may write to the folder can delete or replace it.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "base/result.hpp"

namespace lcrig {

namespace asio = boost::asio;

class ListeningSocket {
 public:
  using Acceptor = asio::local::stream_protocol::acceptor;

  // Listens at `path` with mode 0660. Replaces a socket file that nobody answers, but no other
  // file. Errors: busy (another program answers), io, invalid_request (too long for a socket).
  static Result<std::shared_ptr<ListeningSocket>> open(asio::any_io_executor executor,
                                                       const std::string& path);
  ~ListeningSocket();  // closes it
  ListeningSocket(const ListeningSocket&) = delete;
  ListeningSocket& operator=(const ListeningSocket&) = delete;

  Acceptor& acceptor() { return acceptor_; }
  // Error: in words, why no client can find this socket.
  Result<> is_found() const;
  // Removes the file if it is still this socket's, and refuses clients from now on.
  void close();

 private:
  ListeningSocket(asio::any_io_executor executor, std::string path);
  Result<> bind();

  std::string path_;
  Acceptor acceptor_;
  std::uint64_t device_ = 0, inode_ = 0;  // of the file; 0: none was made
};

}  // namespace lcrig
