// SPDX-License-Identifier: Apache-2.0
// Runs a coroutine to its end from a plain test body, because ASSERT_* do not compile in a
// coroutine.
#pragma once

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "base/clock.hpp"

namespace lcrig {

namespace support {
template <class T>
struct Outcome {
  std::optional<T> value;
  std::exception_ptr error;
  bool done = false;
};
template <class T>
void spawn(asio::io_context& io, Task<T> task, Outcome<T>& out) {
  asio::co_spawn(io, std::move(task), [&out](std::exception_ptr error, T value) {
    out.error = error;
    if (!error) out.value.emplace(std::move(value));
    out.done = true;
  });
}
template <class T>
T take(Outcome<T>& out) {
  if (out.error) std::rethrow_exception(out.error);
  if (!out.value) throw std::logic_error("the task never ended: nothing left to wait for");
  return std::move(*out.value);
}
}  // namespace support

// In real time.
template <class T>
T run_task(asio::io_context& io, Task<T> task) {
  support::Outcome<T> out;
  support::spawn(io, std::move(task), out);
  io.restart();
  while (!out.done && io.run_one() > 0) {
  }
  return support::take(out);
}

// In virtual time.
template <class T>
T run_task(asio::io_context& io, VirtualClock& clock, Task<T> task) {
  support::Outcome<T> out;
  support::spawn(io, std::move(task), out);
  clock.run(io, [&out] { return out.done; });
  return support::take(out);
}

}  // namespace lcrig
