// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/instruments.hpp"

#include "base/clock.hpp"

namespace lcrig {

Task<> InstrumentFactory::ask() {
  co_return;
}

Task<Result<std::unique_ptr<LoneMeter>>> InstrumentFactory::open_lone_meter() {
  co_return fail(Errc::unsupported, "this rig has no meter that could be used without a run");
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
