// SPDX-License-Identifier: Apache-2.0
#include "base/either.hpp"

#include <boost/asio/experimental/awaitable_operators.hpp>

namespace lcrig {

namespace asio = boost::asio;

Task<std::size_t> first_to_end(Task<> a, Task<> b) {
  using namespace asio::experimental::awaitable_operators;
  const auto ended = co_await (std::move(a) || std::move(b));
  co_return ended.index();
}

Task<> both(Task<> a, Task<> b) {
  using namespace asio::experimental::awaitable_operators;
  co_await (std::move(a) && std::move(b));
}

}  // namespace lcrig
