// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/room.hpp"

#include <filesystem>

#include "storage/database.hpp"

namespace lcrig {

namespace {

double megabytes(std::uintmax_t bytes) {
  return static_cast<double>(bytes) / 1e6;
}

}  // namespace

Result<> require_room(const std::string& database, std::int64_t bytes) {
  std::error_code unknown;
  const auto folder = std::filesystem::absolute(database, unknown).parent_path();
  const auto space = std::filesystem::space(folder, unknown);
  const auto needed = static_cast<std::uintmax_t>(bytes + kStaysFree_bytes);
  if (unknown || space.available >= needed) return {};
  return fail(Errc::io,
              "{}: {:.1f} MB are free, but what is planned needs {:.1f} MB, and {:.1f} MB have to "
              "stay free: free some space, or move the database to a larger disk",
              folder.string(), megabytes(space.available),
              megabytes(static_cast<std::uintmax_t>(bytes)),
              megabytes(static_cast<std::uintmax_t>(kStaysFree_bytes)));
}

}  // namespace lcrig
