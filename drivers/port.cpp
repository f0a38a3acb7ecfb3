// SPDX-License-Identifier: Apache-2.0
#include "drivers/port.hpp"

#include <boost/asio/this_coro.hpp>

#include "drivers/port_url.hpp"
#include "drivers/tcp_transport.hpp"

namespace lcrig {

namespace {
constexpr Duration kConnectTime = std::chrono::seconds(5);
}

Task<Result<std::unique_ptr<Transport>>> open_port(std::string url, SerialSettings settings,
                                                   Clock& clock) {
  const auto parsed = parse_port_url(url);
  if (!parsed) co_return fail(parsed.error());
  if (parsed->kind == PortKind::tcp) {
    const MonoTime deadline = clock.now() + kConnectTime;
    co_return co_await open_tcp(parsed->host, parsed->tcp_port, clock, deadline);
  }
  const auto executor = co_await asio::this_coro::executor;
  if (parsed->kind == PortKind::pty || (parsed->kind == PortKind::path && is_pty(parsed->path))) {
    co_return open_pty(executor, clock, parsed->path);
  }
  co_return open_serial(executor, clock, *parsed, settings);
}

bool is_port_there(const std::string& url) {
  const auto parsed = parse_port_url(url);
  return !parsed || parsed->kind == PortKind::tcp || is_serial_there(*parsed);
}

}  // namespace lcrig
