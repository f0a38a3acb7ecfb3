// SPDX-License-Identifier: Apache-2.0
// The picture of a report that shows what the watch over the frame allowed.
#pragma once

#include <cstdint>
#include <optional>

#include "analysis/report/report.hpp"
#include "storage/database.hpp"

namespace lcrig::cli {

// nullopt: the run pressed nothing, or its inputs are not stored or not readable.
std::optional<WatchPicture> watch_picture(const Database& db, std::int64_t run);

}  // namespace lcrig::cli
