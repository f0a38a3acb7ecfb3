// SPDX-License-Identifier: Apache-2.0
// The frame's capabilities as a run's row stores them: all that bounds its motions and its force
// loop, so that a stored run can be computed again. Used by Session, and to replay runs.
#pragma once

#include "drivers/load_frame.hpp"
#include "storage/frame_capabilities.hpp"

namespace lcrig {

StoredCapabilities stored_capabilities(const FrameCapabilities& capabilities);
// The reverse. What an older lcrig did not store is as FrameCapabilities has it by default.
FrameCapabilities frame_capabilities(const StoredCapabilities& stored);

}  // namespace lcrig
