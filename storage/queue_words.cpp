// SPDX-License-Identifier: Apache-2.0
// Words of the queue in the database and on the wire, for programs that read them without a
// database.
#include <array>
#include <cstddef>

#include "storage/queue.hpp"
#include "storage/queue_run.hpp"

namespace lcrig {

std::string_view to_string(EntryState state) {
  constexpr std::array<std::string_view, 7> kWords{"waiting", "running", "interrupted", "failed",
                                                   "done",    "skipped", "removed"};
  return kWords[static_cast<std::size_t>(state)];
}

std::string_view to_string(HeadChoice choice) {
  constexpr std::array<std::string_view, 4> kWords{"none", "resume", "repeat", "skip"};
  return kWords[static_cast<std::size_t>(choice)];
}

}  // namespace lcrig
