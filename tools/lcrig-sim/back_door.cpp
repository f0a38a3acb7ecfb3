// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig-sim/back_door.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/as_result.hpp"

namespace lcrig::sim {

using nlohmann::json;

namespace {
constexpr std::size_t kMaxLine = 1000;
constexpr Duration kSettleTime = std::chrono::seconds(10);

std::string answer_to(Bench& bench, std::string_view line) {
  json out;
  if (auto state = obey(bench, line)) {
    out = std::move(*state);
    out["ok"] = true;
  } else {
    out["ok"] = false;
    out["error"] = state.error().what;
  }
  return out.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace

BackDoor::BackDoor(const asio::any_io_executor& executor, Tasks& tasks, Bench bench)
    : tasks_(tasks), bench_(bench), acceptor_(executor) {}

BackDoor::~BackDoor() {
  close();
}

Result<> BackDoor::listen(const std::string& path) {
  struct stat found{};
  if (::lstat(path.c_str(), &found) == 0 && S_ISSOCK(found.st_mode)) ::unlink(path.c_str());
  boost::system::error_code ec;
  acceptor_.open(asio::local::stream_protocol(), ec);
  if (path.size() >= sizeof(sockaddr_un::sun_path)) {
    return fail(Errc::invalid_request, "--control {}: a socket's path has at most {} bytes", path,
                sizeof(sockaddr_un::sun_path) - 1);
  }
  if (!ec) acceptor_.bind(asio::local::stream_protocol::endpoint(path), ec);
  if (!ec) acceptor_.listen(asio::socket_base::max_listen_connections, ec);
  if (ec) return fail(Errc::io, "--control {}: {}", path, ec.message());
  path_ = path;
  tasks_.start(accept());
  return {};
}

void BackDoor::close() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  if (!path_.empty()) ::unlink(std::exchange(path_, {}).c_str());
}

Task<> BackDoor::accept() {
  while (acceptor_.is_open()) {
    auto r = co_await acceptor_.async_accept(kAsResult);
    auto& [ec, socket] = r;
    if (ec) co_return;
    tasks_.start(serve(std::move(socket)));
  }
}

Task<> BackDoor::serve(Socket socket) {
  std::string in;
  for (;;) {
    auto r = co_await asio::async_read_until(socket, asio::dynamic_buffer(in, kMaxLine), '\n',
                                             kAsResult);
    if (std::get<0>(r)) co_return;
    const std::size_t n = std::get<1>(r);
    if (in.starts_with("settle")) co_await settle();
    const std::string out = answer_to(bench_, std::string_view(in).substr(0, n - 1));
    in.erase(0, n);
    const auto bytes = asio::buffer(out);
    auto written = co_await asio::async_write(socket, bytes, kAsResult);
    if (std::get<0>(written)) co_return;
  }
}

Task<> BackDoor::settle() {
  const MonoTime limit = bench_.clock.now() + kSettleTime;
  while (is_moving(bench_) && bench_.clock.now() < limit && acceptor_.is_open()) {
    co_await bench_.clock.wait_for(std::chrono::milliseconds(2));
  }
}

}  // namespace lcrig::sim
