// SPDX-License-Identifier: Apache-2.0
// Stands in for the drivers. The config parser stores a pointer to the driver that a file names and
// never calls it, so the fuzzed program needs none.
#include "drivers/registry.hpp"

namespace lcrig {

std::unique_ptr<LcrMeter> make_lcr6100(std::unique_ptr<Transport> /*transport*/, Clock& /*clock*/,
                                       std::string /*serial*/) {
  return nullptr;
}

}  // namespace lcrig
