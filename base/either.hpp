// SPDX-License-Identifier: Apache-2.0
// Runs two coroutines at once: a wait beside its deadline, a step beside its interruption. It does
// the same as Asio's `a || b` and `a && b`. Their templates cost each file that uses them five
// seconds of compile time under the sanitizers; here they are compiled once, for coroutines without
// a result.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/task.hpp"

namespace lcrig {

// Returns which one ended first, 0 or 1. The other is cancelled (terminal) and awaited.
Task<std::size_t> first_to_end(Task<> a, Task<> b);
// Ends when both have ended. When one throws, the other is cancelled.
Task<> both(Task<> a, Task<> b);

namespace detail {

template <class T>
using Kept = std::conditional_t<std::is_void_v<T>, std::monostate, T>;

template <class T>
Task<> keep(Task<T> task, std::optional<Kept<T>>& into) {
  if constexpr (std::is_void_v<T>) {
    co_await std::move(task);
    into.emplace();
  } else {
    T value = co_await std::move(task);
    into.emplace(std::move(value));
  }
}

}  // namespace detail

// The result of the coroutine that ended first, at its index. The other is cancelled, as in
// first_to_end.
template <class A, class B>
Task<std::variant<detail::Kept<A>, detail::Kept<B>>> either(Task<A> a, Task<B> b) {
  std::optional<detail::Kept<A>> of_a;
  std::optional<detail::Kept<B>> of_b;
  auto first = detail::keep(std::move(a), of_a);
  auto second = detail::keep(std::move(b), of_b);
  const std::size_t ended = co_await first_to_end(std::move(first), std::move(second));
  using Result = std::variant<detail::Kept<A>, detail::Kept<B>>;
  if (ended == 0) co_return Result(std::in_place_index<0>, std::move(*of_a));
  co_return Result(std::in_place_index<1>, std::move(*of_b));
}

}  // namespace lcrig
