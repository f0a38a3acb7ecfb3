// SPDX-License-Identifier: Apache-2.0
// Puts the detail of an event row into words, for the command line and the daemon's journal.
#pragma once

#include <string>
#include <string_view>

namespace lcrig {

// A payload of fields becomes "travel 3.2005 mm, force 0.0234 N": each key with its unit, lengths
// in mm, without fields that are null. A detail that is already words stays as it is.
std::string event_words(std::string_view detail);

}  // namespace lcrig
