// SPDX-License-Identifier: Apache-2.0
#include "drivers/dead_weight/sim.hpp"

#include "base/clock.hpp"

namespace lcrig {

Task<Result<>> SimOperator::confirm(std::string prompt) {
  prompt_ = prompt;
  bool came = co_await clock_.wait_for(delay_);
  while (came && absent_) came = co_await clock_.wait_for(std::chrono::seconds(1));
  prompt_.clear();
  if (!came) co_return fail(Errc::aborted, "the prompt was withdrawn: {}", prompt);
  if (act_) act_(prompt);
  co_return Result<>();
}

}  // namespace lcrig
