// SPDX-License-Identifier: Apache-2.0
// Reads from /proc/stat what the processors did since the computer was started. The daemon's
// metrics and `lcrig doctor` show from it how much time the host of a virtual machine took away.
#pragma once

#include <filesystem>
#include <optional>

namespace lcrig {

struct ProcessorTicks {  // summed over all processors
  double all = 0, steal = 0;
};
// nullopt: the file does not contain it.
std::optional<ProcessorTicks> read_processor_ticks(const std::filesystem::path& proc_stat);

}  // namespace lcrig
