// SPDX-License-Identifier: Apache-2.0
// The person at the rig, who confirms with `lcrig confirm` or Enter. The daemon has one, and the
// instruments of its runs ask it.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <string>

#include "base/clock.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

class RemoteOperator final : public Operator {
 public:
  explicit RemoteOperator(asio::any_io_executor executor) : confirmations_(executor, 1) {}
  Task<Result<>> confirm(std::string prompt) override;
  bool confirmed();  // false: nothing waits for a confirmation
  const std::string& prompt() const override { return prompt_; }

 private:
  asio::experimental::channel<void(boost::system::error_code)> confirmations_;
  std::string prompt_;
};

}  // namespace lcrig
