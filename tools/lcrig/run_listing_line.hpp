// SPDX-License-Identifier: Apache-2.0
// One run as a line of JSON. `lcrig runs list` and `runs show` use it.
#pragma once

#include <string>

#include "storage/runs.hpp"

namespace lcrig::cli {

// As docs/cli-json.md promises. No JSON value is
// made of it: ten thousand of them take longer than reading the runs.
std::string run_listing_line(const RunListing& run);

}  // namespace lcrig::cli
