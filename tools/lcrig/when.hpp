// SPDX-License-Identifier: Apache-2.0
// Reads a time as a person types it, in the local time of this computer. `lcrig runs` and the terms
// of `lcrig queue add` use it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lcrig::cli {

// "22:00" (the next one from `now` on), "2026-11-24" (its beginning), "2026-11-24 06:00" or with a
// T, with or without seconds. With a Z at the end it is UTC, as `lcrig runs` prints it, instead of
// local time. nullopt: it is something else, or the day does not exist.
std::optional<std::int64_t> unix_time_of(std::string_view text, std::int64_t now_unix_s);

// "2026-11-24" from "24.11.2026". nullopt: it has another form, or the day does not exist.
std::optional<std::string> iso_day_of(std::string_view text);

}  // namespace lcrig::cli
