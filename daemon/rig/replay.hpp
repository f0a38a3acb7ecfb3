// SPDX-License-Identifier: Apache-2.0
// A recording as the instruments of a run: it is played through the simulators' wires, so that the
// drivers read it as they read a rig.
#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "daemon/rig/instruments.hpp"

namespace lcrig {

// Plays lcr.csv and frame.csv of a directory. Errors: as load_recording.
Result<std::unique_ptr<Instruments>> make_replay_instruments(asio::any_io_executor executor,
                                                             Clock& clock,
                                                             const std::string& directory);

}  // namespace lcrig
