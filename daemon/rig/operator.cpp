// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/operator.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <memory>
#include <utility>

namespace lcrig {

Task<Result<>> RemoteOperator::confirm(std::string prompt) {
  while (confirmations_.try_receive([](auto&&...) {})) {
  }
  prompt_ = std::move(prompt);
  // Clears the prompt when the wait ends, even by cancellation.
  const auto clear = [](std::string* p) { p->clear(); };
  const std::unique_ptr<std::string, decltype(clear)> guard(&prompt_, clear);
  auto r = co_await confirmations_.async_receive(asio::as_tuple(asio::use_awaitable));
  if (std::get<0>(r)) co_return fail(Errc::aborted, "the prompt was withdrawn");
  co_return Result<>();
}

bool RemoteOperator::confirmed() {
  return !prompt_.empty() && confirmations_.try_send(boost::system::error_code());
}

}  // namespace lcrig
