// SPDX-License-Identifier: Apache-2.0
#include "drivers/port.hpp"

#include <boost/asio/this_coro.hpp>

#include "base/aside.hpp"
#include "base/port_url.hpp"
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
  const auto open = [wanted = *parsed, settings] {
    const bool pty = wanted.kind == PortKind::pty;
    if (pty || (wanted.kind == PortKind::path && is_pty(wanted.path))) return open_pty(wanted.path);
    return open_serial(wanted, settings);
  };
  auto opened = co_await run_abandonable(executor, clock, open);
  if (!opened) co_return fail(Errc::aborted, "{}: nobody waits for the port any more", url);
  if (!*opened) co_return fail(opened->error());
  co_return std::move(**opened).to_transport(executor, clock);
}

bool is_port_there(const std::string& url) {
  const auto parsed = parse_port_url(url);
  return !parsed || parsed->kind == PortKind::tcp || is_serial_there(*parsed);
}

}  // namespace lcrig
