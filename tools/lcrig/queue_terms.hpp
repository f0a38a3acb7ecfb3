// SPDX-License-Identifier: Apache-2.0
// The options of `lcrig queue add` for the terms on which an entry waits in the queue.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

class TermsOptions {
 public:
  void declare(ArgumentList& list);
  // Members of queue.add. Failure: usage.
  Outcome<bool> put_into(nlohmann::json& params, std::int64_t now_unix_s) const;

 private:
  Outcome<bool> put_times(nlohmann::json& params, std::int64_t now_unix_s) const;
  std::string on_failure_, failures_max_, not_before_, not_after_, between_, probe_, fixture_;
  std::string rest_;
  bool unattended_ = false;
};

}  // namespace lcrig::cli
