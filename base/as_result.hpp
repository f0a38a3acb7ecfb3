// SPDX-License-Identifier: Apache-2.0
// How an Asio operation is awaited here: its error comes as a value, never as an exception.
#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace lcrig {

// co_await gives a tuple (error_code, ...).
inline constexpr auto kAsResult = boost::asio::as_tuple(boost::asio::use_awaitable);

}  // namespace lcrig
