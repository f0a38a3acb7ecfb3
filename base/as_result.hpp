// SPDX-License-Identifier: Apache-2.0
// The completion token for every Asio operation that a coroutine awaits. With it errors come back
// as values. With plain use_awaitable a failed read throws, and an operation that throws does not
// win a race against a timeout.
#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace lcrig {

// co_await with this token returns a tuple (error_code, ...).
inline constexpr auto kAsResult = boost::asio::as_tuple(boost::asio::use_awaitable);

}  // namespace lcrig
