// SPDX-License-Identifier: Apache-2.0
// The instruments that the turns of a queue meet are those of the first one after a person started
// it: another one is never commanded without a person's word.
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
