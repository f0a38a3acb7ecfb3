// SPDX-License-Identifier: Apache-2.0
#include "drivers/registry.hpp"

#include "drivers/lcr6100/driver.hpp"

namespace lcrig {

std::unique_ptr<LcrMeter> make_lcr6100(std::unique_ptr<Transport> transport, Clock& clock,
                                       std::string serial) {
  return std::make_unique<lcr6100::Lcr6100>(std::move(transport), clock, std::move(serial));
}

}  // namespace lcrig
