// SPDX-License-Identifier: Apache-2.0
// The table of meter drivers. A new driver adds one line. The configuration looks drivers up here.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/lcr_meter.hpp"
#include "drivers/transport.hpp"

namespace lcrig {

// Takes an open port. `serial` is the required serial number; empty accepts any.
using MakeMeter = std::unique_ptr<LcrMeter> (*)(std::unique_ptr<Transport> transport, Clock& clock,
                                                std::string serial);
std::unique_ptr<LcrMeter> make_lcr6100(std::unique_ptr<Transport> transport, Clock& clock,
                                       std::string serial);

struct MeterDriver {
  std::string_view name;  // in the configuration
  std::string_view instrument;  // shown to people
  MakeMeter make;
};

inline constexpr std::array kMeterDrivers{
    MeterDriver{"lcr6100", "GW Instek LCR-6000 series", make_lcr6100},
};

}  // namespace lcrig
