// SPDX-License-Identifier: Apache-2.0
// The return type of a coroutine, for headers that only declare coroutines. Code that defines or
// awaits one includes base/clock.hpp, whose Asio headers cost each file a second of compile time.
#pragma once

namespace boost::asio {
class any_io_executor;
template <typename T, typename Executor>
class awaitable;
}  // namespace boost::asio

namespace lcrig {

namespace asio = boost::asio;

// A coroutine. Its parameters must be values, or references to objects that App owns.
template <class T = void>
using Task = boost::asio::awaitable<T, boost::asio::any_io_executor>;

}  // namespace lcrig
