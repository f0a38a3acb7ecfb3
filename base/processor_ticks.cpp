// SPDX-License-Identifier: Apache-2.0
#include "base/processor_ticks.hpp"

#include <array>
#include <fstream>
#include <numeric>
#include <string>

namespace lcrig {

std::optional<ProcessorTicks> read_processor_ticks(const std::filesystem::path& proc_stat) {
  std::ifstream file(proc_stat);
  std::string word;
  std::array<double, 8> ticks{};  // user, nice, system, idle, iowait, irq, softirq, steal
  file >> word;
  for (double& value : ticks) file >> value;
  if (!file || word != "cpu") return std::nullopt;
  const double all = std::accumulate(ticks.begin(), ticks.end(), 0.0);
  return ProcessorTicks{.all = all, .steal = ticks.back()};
}

}  // namespace lcrig
