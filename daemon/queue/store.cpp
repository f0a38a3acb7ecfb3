// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/store.hpp"

#include <filesystem>

namespace lcrig {

Result<> QueueStore::check_room(std::int64_t bytes) const {
  std::error_code unknown;
  const auto folder = std::filesystem::absolute(path_).parent_path();
  const auto space = std::filesystem::space(folder, unknown);
  if (unknown || space.available >= static_cast<std::uintmax_t>(bytes)) return {};
  return fail(Errc::io, "{}: {:.1f} MB are free, and the runs that wait need {:.1f} MB: free some",
              folder.string(), static_cast<double>(space.available) / 1e6,
              static_cast<double>(bytes) / 1e6);
}

}  // namespace lcrig
