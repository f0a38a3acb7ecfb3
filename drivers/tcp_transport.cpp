// SPDX-License-Identifier: Apache-2.0
#include "drivers/tcp_transport.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/this_coro.hpp>
#include <vector>

#include "base/as_result.hpp"
#include "base/clock.hpp"
#include "base/doc_page.hpp"
#include "base/either.hpp"
#include "drivers/fd_transport.hpp"

namespace lcrig {

namespace {

using asio::ip::tcp;

tl::unexpected<Error> silent(const std::string& name) {
  return fail(Errc::no_reply, "{}: the host does not answer; check its address and the network",
              name);
}

// The shipped service cannot reach a name server, and its drop-in allows addresses only.
Error lookup_error(const std::string& name, const boost::system::error_code& error) {
  return Error(Errc::disconnected,
               fmt::format("{}: no address was found for this host name ({}). Is the name right? "
                           "The shipped service is shut in and reaches no name server: give the "
                           "numeric address, and install the drop-in lcrigd-tcp.conf ({})",
                           name, error.message(), doc_page("lab-setup")));
}

// A numeric address needs no name server and therefore no deadline.
Task<Result<std::vector<tcp::endpoint>>> find_endpoints(std::string host, std::uint16_t port,
                                                        std::string name, Clock& clock,
                                                        MonoTime deadline) {
  std::vector<tcp::endpoint> out;
  boost::system::error_code ec;
  const auto address = asio::ip::make_address(host, ec);
  if (!ec) {
    out.emplace_back(address, port);
    co_return out;
  }
  tcp::resolver resolver(co_await asio::this_coro::executor);
  const std::string service = std::to_string(port);
  auto r =
      co_await either(resolver.async_resolve(host, service, kAsResult), clock.wait_until(deadline));
  if (r.index() == 1) co_return silent(name);
  const auto& [error, found] = std::get<0>(r);
  if (error) co_return tl::unexpected<Error>(lookup_error(name, error));
  for (const auto& entry : found) out.push_back(entry.endpoint());
  co_return out;
}

}  // namespace

// In a service without network Asio reports that no socket can be made (as an aborted operation),
// or that no host can be reached.
Error connect_error(const std::string& name, const boost::system::error_code& error) {
  using asio::error::basic_errors;
  const bool shut_in =
      error == basic_errors::operation_aborted || error == basic_errors::no_permission ||
      error == basic_errors::address_family_not_supported || error == basic_errors::access_denied ||
      error == basic_errors::network_unreachable;
  const std::string advice =
      shut_in ? "this process has no way to the network. The shipped service is shut in: install "
                "the drop-in lcrigd-tcp.conf (" +
                    doc_page("lab-setup") + ")"
              : "is the program there running?";
  const std::string what =
      error == basic_errors::operation_aborted ? "no socket can be made" : error.message();
  return Error(Errc::disconnected, fmt::format("{}: {}; {}", name, what, advice));
}

Task<Result<std::unique_ptr<Transport>>> open_tcp(std::string host, std::uint16_t port,
                                                  Clock& clock, MonoTime deadline) {
  const std::string name = fmt::format("tcp:{}:{}", host, port);
  auto endpoints = co_await find_endpoints(host, port, name, clock, deadline);
  if (!endpoints) co_return fail(endpoints.error());
  const auto executor = co_await asio::this_coro::executor;
  tcp::socket socket(executor);
  auto r = co_await either(asio::async_connect(socket, *endpoints, kAsResult),
                           clock.wait_until(deadline));
  if (r.index() == 1) co_return silent(name);
  const auto& error = std::get<0>(std::get<0>(r));
  if (error) co_return tl::unexpected<Error>(connect_error(name, error));
  boost::system::error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  const int fd = socket.release();
  co_return std::make_unique<FdTransport>(executor, clock, fd, name);
}

}  // namespace lcrig
