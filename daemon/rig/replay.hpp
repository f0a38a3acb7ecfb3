// SPDX-License-Identifier: Apache-2.0
// A recording as the instruments of a run. It is played through the wires of the simulators, so
// that the drivers read it like a rig.
#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "daemon/rig/instruments.hpp"

namespace lcrig {

// Plays lcr.csv and frame.csv from a directory. Errors: as load_recording.
Result<std::unique_ptr<Instruments>> make_replay_instruments(asio::any_io_executor executor,
                                                             Clock& clock,
                                                             const std::string& directory);

}  // namespace lcrig
