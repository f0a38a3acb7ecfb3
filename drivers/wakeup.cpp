// SPDX-License-Identifier: Apache-2.0
#include "drivers/wakeup.hpp"

#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <boost/asio/this_coro.hpp>

#include "base/as_result.hpp"

namespace lcrig {

namespace {
using namespace asio::experimental::awaitable_operators;
}  // namespace

struct Wakeup::Channel {
  explicit Channel(asio::any_io_executor executor) : channel(std::move(executor), 1) {}
  asio::experimental::channel<void(boost::system::error_code)> channel;
};

Wakeup::Wakeup(asio::any_io_executor executor)
    : channel_(std::make_unique<Channel>(std::move(executor))) {}
Wakeup::~Wakeup() = default;

void Wakeup::notify() {
  channel_->channel.try_send(boost::system::error_code());  // false: a knock is remembered already
}

Task<> Wakeup::wait() {
  auto r = co_await channel_->channel.async_receive(kAsResult);
  static_cast<void>(r);
}

Task<> Wakeup::wait_until(Clock& clock, MonoTime deadline) {
  auto r = co_await (channel_->channel.async_receive(kAsResult) || clock.wait_until(deadline));
  static_cast<void>(r);
}

}  // namespace lcrig
