// SPDX-License-Identifier: Apache-2.0
#include "drivers/memory_pipe.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "base/clock.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kCapacity = 64 * 1024;  // bytes under way to one end

class MemoryPipeEnd final : public Transport {
 public:
  MemoryPipeEnd(asio::any_io_executor executor, Clock& clock, std::string name)
      : executor_(executor), clock_(clock), name_(std::move(name)) {}
  ~MemoryPipeEnd() override { close(); }
  void join(MemoryPipeEnd& peer) {
    peer_ = &peer;
    peer.peer_ = this;
  }

  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override {
    if (!open_) co_return fail(Errc::disconnected, "{}: the port is closed", name_);
    // Every 64th read lets other coroutines run first, so that a peer that floods the line cannot
    // starve them.
    const bool only_look = deadline <= clock_.now();
    if (!only_look && ++reads_ % 64 == 0) co_await asio::post(executor_, asio::use_awaitable);
    while (true) {
      if (!open_) co_return gone("read");
      if (!inbox_.empty()) co_return take(buffer);
      if (peer_ == nullptr) co_return gone("read");
      if (deadline <= clock_.now()) {
        co_return fail(Errc::no_reply, "{}: nothing received in time", name_);
      }
      co_await clock_.wait_until(deadline, arrived_);
      const auto state = co_await asio::this_coro::cancellation_state;
      if (state.cancelled() != asio::cancellation_type::none) co_return gone("read");
    }
  }

  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override {
    if (!open_) co_return fail(Errc::disconnected, "{}: the port is closed", name_);
    while (true) {
      if (peer_ == nullptr) co_return gone("write");
      bytes.remove_prefix(peer_->accept(bytes));
      if (bytes.empty()) co_return Result<>();
      if (deadline <= clock_.now()) {
        co_return fail(Errc::io, "{}: the other side takes no bytes", name_);
      }
      co_await clock_.wait_until(deadline, room_);
      const auto state = co_await asio::this_coro::cancellation_state;
      if (state.cancelled() != asio::cancellation_type::none) co_return gone("write");
    }
  }

  void close() override {
    if (!std::exchange(open_, false)) return;
    arrived_.notify();
    room_.notify();
    if (MemoryPipeEnd* peer = std::exchange(peer_, nullptr)) {
      peer->peer_ = nullptr;
      peer->arrived_.notify();
      peer->room_.notify();
    }
  }

  const std::string& name() const override { return name_; }

 private:
  std::size_t take(std::span<char> buffer) {
    const bool was_full = inbox_.size() == kCapacity;
    const std::size_t n = inbox_.copy(buffer.data(), buffer.size());
    inbox_.erase(0, n);
    if (was_full && peer_ != nullptr) peer_->room_.notify();
    return n;
  }

  std::size_t accept(std::string_view bytes) {
    const std::size_t n = std::min(bytes.size(), kCapacity - inbox_.size());
    inbox_.append(bytes, 0, n);
    if (n > 0) arrived_.notify();
    return n;
  }

  tl::unexpected<Error> gone(std::string_view during) const {
    return fail(Errc::disconnected, "{}: the port went away ({})", name_, during);
  }

  asio::any_io_executor executor_;
  Clock& clock_;
  std::string name_;
  bool open_ = true;
  MemoryPipeEnd* peer_ = nullptr;  // nullptr: closed
  std::string inbox_;  // sent by the peer and not yet read
  Wakeup arrived_;  // notified when bytes arrived or an end closed
  Wakeup room_;  // notified when the peer has read or an end closed
  unsigned reads_ = 0;
};

}  // namespace

TransportPair make_memory_pipe(asio::any_io_executor executor, Clock& clock,
                               const std::string& name) {
  auto near = std::make_unique<MemoryPipeEnd>(executor, clock, name);
  auto far = std::make_unique<MemoryPipeEnd>(executor, clock, name + " (far end)");
  near->join(*far);
  return {.near = std::move(near), .far = std::move(far)};
}

}  // namespace lcrig
