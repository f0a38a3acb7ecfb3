// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "storage/runs.hpp"

namespace lcrig::cli {

// One run as `lcrig runs list --json` prints it, as docs/cli-json.md promises. No JSON value is
// made of it: ten thousand of them take longer than reading the runs.
std::string run_listing_line(const RunListing& run);

}  // namespace lcrig::cli
