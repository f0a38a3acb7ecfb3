// SPDX-License-Identifier: Apache-2.0
#include "base/iso_time.hpp"

#include <fmt/chrono.h>

#include <chrono>

namespace lcrig {

std::string iso_time(std::int64_t unix_ns) {
  const auto ms = std::chrono::floor<std::chrono::milliseconds>(std::chrono::nanoseconds(unix_ns));
  const auto s = std::chrono::floor<std::chrono::seconds>(ms);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}+00:00",
                     fmt::gmtime(static_cast<std::time_t>(s.count())), (ms - s).count());
}

}  // namespace lcrig
