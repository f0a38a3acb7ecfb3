// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/instruments.hpp"

#include "base/clock.hpp"

namespace lcrig {

Task<> InstrumentFactory::ask() {
  co_return;
}

Task<> InstrumentFactory::ask_meter() {
  co_return;
}

Task<bool> InstrumentFactory::make_frame_safe() {
  co_return true;
}

Task<bool> InstrumentFactory::watch_ports() {
  co_return false;
}

}  // namespace lcrig
