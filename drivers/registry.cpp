// SPDX-License-Identifier: Apache-2.0
#include "drivers/registry.hpp"

#include <algorithm>

#include "drivers/lcr6100/driver.hpp"

namespace lcrig {

std::unique_ptr<LcrMeter> make_lcr6100(std::unique_ptr<Transport> transport, Clock& clock,
                                       std::string serial) {
  return std::make_unique<lcr6100::Lcr6100>(std::move(transport), clock, std::move(serial));
}

const MeterDriver* find_meter_driver(std::string_view name) {
  const auto* it = std::ranges::find(kMeterDrivers, name, &MeterDriver::name);
  return it == kMeterDrivers.end() ? nullptr : it;
}

}  // namespace lcrig
