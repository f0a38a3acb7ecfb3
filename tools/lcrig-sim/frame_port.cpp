// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig-sim/frame_port.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <utility>

#include "base/as_result.hpp"
#include "drivers/fd_transport.hpp"

namespace lcrig::sim {

namespace {

using namespace std::chrono_literals;
using asio::ip::tcp;

// How long to wait for the end of file of a killed client, which arrives a moment after its end.
constexpr Duration kPatience = 500ms;

}  // namespace

FramePort::FramePort(asio::any_io_executor executor, Clock& clock, Tasks& tasks, FrameScene& scene,
                     ZwickSimSettings settings)
    : executor_(std::move(executor)),
      clock_(clock),
      tasks_(tasks),
      scene_(scene),
      settings_(std::move(settings)),
      acceptor_(executor_) {}

Result<> FramePort::listen(std::uint16_t tcp_port) {
  tcp_port_ = tcp_port;
  auto bound = bind();
  if (!bound) return bound;
  url_ = fmt::format("tcp://127.0.0.1:{}", tcp_port_);
  return {};
}

Result<> FramePort::bind() {
  boost::system::error_code ec;
  const tcp::endpoint here(asio::ip::address_v4::loopback(), tcp_port_);
  acceptor_.open(here.protocol(), ec);
  if (!ec) acceptor_.set_option(tcp::acceptor::reuse_address(true), ec);
  if (!ec) acceptor_.bind(here, ec);
  if (!ec) acceptor_.listen(asio::socket_base::max_listen_connections, ec);
  if (ec) {
    acceptor_.close();
    return fail(Errc::io, "127.0.0.1:{}: {}; give another --frame-port", tcp_port_, ec.message());
  }
  tcp_port_ = acceptor_.local_endpoint().port();
  tasks_.start(accept());
  return {};
}

Result<> FramePort::open_pty() {
  if (auto r = keep(Pty::open(), pty_); !r) return fail(r.error());
  url_ = "pty:" + pty_->path();
  serve(pty_->release_master(), "sim:" + url_);
  return {};
}

void FramePort::unplug() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  pty_.reset();
  if (gateway_) gateway_->close();
}

Result<> FramePort::plug() {
  if (acceptor_.is_open() || pty_) return {};
  return tcp_port_ == 0 ? open_pty() : bind();
}

void FramePort::hook(ZwickSimHooks hooks) {
  hooks_ = std::move(hooks);
  if (gateway_) gateway_->hooks = hooks_;
  if (parked_) parked_->hooks = hooks_;
}

void FramePort::change(const std::function<void(ZwickSimFaults&)>& change) {
  change(lasting_);
  // These faults apply to the present connection only.
  lasting_.lose_samples = lasting_.spike_samples = 0;
  lasting_.lose_tare = lasting_.tell_origin = false;
  if (!gateway_) return;
  change(gateway_->faults);
  gateway_->poke();
}

void FramePort::heal() {
  lasting_ = ZwickSimFaults();
  if (!gateway_) return;
  gateway_->faults = lasting_;
  gateway_->poke();
}

void FramePort::forget() {
  if (gateway_) gateway_->forget();
  if (parked_) parked_->forget();
}

void FramePort::restart(bool forgets_zero) {
  if (forgets_zero) forget();
  if (gateway_) gateway_->restart();
}

Task<> FramePort::accept() {
  while (acceptor_.is_open()) {
    auto r = co_await acceptor_.async_accept(kAsResult);
    auto& [ec, socket] = r;
    if (!ec) {
      boost::system::error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      tasks_.start(admit(socket.release()));
    } else if (acceptor_.is_open()) {
      spdlog::warn("{}: {}", url_, ec.message());
      co_await clock_.wait_for(100ms);
    }
  }
}

Task<> FramePort::admit(int fd) {
  const MonoTime limit = clock_.now() + kPatience;
  const auto gone = [this] { return !gateway_; };
  co_await tasks_.until(gone, limit);
  if (gateway_ || !acceptor_.is_open()) {
    spdlog::warn("{}: a second client is sent away", url_);
    ::close(fd);
    co_return;
  }
  serve(fd, "sim:" + url_);
}

// It is one machine, which keeps position, tare and clock from one connection to the next.
void FramePort::serve(int fd, const std::string& name) {
  auto wire = std::make_unique<FdTransport>(executor_, clock_, fd, name);
  if (parked_) {
    gateway_ = std::move(parked_);
    gateway_->attach(std::move(wire));
  } else {
    gateway_ = std::make_shared<ZwickSim>(std::move(wire), clock_, scene_, settings_);
  }
  gateway_->faults = lasting_;
  gateway_->hooks = hooks_;
  tasks_.start(gateway_->run(), [this, mine = gateway_] {
    if (gateway_ == mine) parked_ = std::move(gateway_);
  });
}

}  // namespace lcrig::sim
