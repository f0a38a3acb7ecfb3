// SPDX-License-Identifier: Apache-2.0
// Remembers which instruments answered at the first turn after a person started the queue. App
// compares each later turn with them, and commands no other instrument without a person's word.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "drivers/lcr_meter.hpp"

namespace lcrig {

class KnownIdentities {
 public:
  // Errors: refused; says who answered instead of whom. `rod`: weights stand for the frame, which
  // is another instrument than the frame that moves.
  Result<> compare(const Identity& meter, const Identity& frame, bool rod);
  void forget();

 private:
  std::optional<Identity> meter_, frame_, rod_;
};

}  // namespace lcrig
