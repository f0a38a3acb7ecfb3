// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/identities.hpp"

#include "drivers/reopening.hpp"

namespace lcrig {

namespace {

Result<> compare_or_keep(std::optional<Identity>& known, const Identity& now) {
  if (known) return compare_identity(*known, now);
  known = now;
  return {};
}

}  // namespace

Result<> KnownIdentities::compare(const Identity& meter, const Identity& frame, bool rod) {
  if (auto same = compare_or_keep(meter_, meter); !same) return same;
  return compare_or_keep(rod ? rod_ : frame_, frame);
}

void KnownIdentities::forget() {
  meter_.reset();
  frame_.reset();
  rod_.reset();
}

}  // namespace lcrig
