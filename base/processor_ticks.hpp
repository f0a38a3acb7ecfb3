// SPDX-License-Identifier: Apache-2.0
// What the processors of this computer did since it was started, by /proc/stat. The daemon's
// metrics and `lcrig doctor` tell how much of it the host of a virtual machine took away.
#pragma once

#include <filesystem>
#include <optional>

namespace lcrig {

struct ProcessorTicks {  // of all processors
  double all = 0, steal = 0;
};
// nullopt: the file does not tell it.
std::optional<ProcessorTicks> read_processor_ticks(const std::filesystem::path& proc_stat);

}  // namespace lcrig
