// SPDX-License-Identifier: Apache-2.0
// The detail of an event row in words. The command line and the daemon's journal show events so.
#pragma once

#include <string>
#include <string_view>

namespace lcrig {

// A payload of fields becomes "travel 3.2005 mm, force 0.0234 N": each key with the unit that it
// ends in, lengths in mm, no field that is null. Words stay as they are.
std::string event_words(std::string_view detail);

}  // namespace lcrig
