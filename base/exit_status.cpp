// SPDX-License-Identifier: Apache-2.0
#include "base/exit_status.hpp"

#include <algorithm>
#include <array>

namespace lcrig {

namespace {

constexpr std::array<std::string_view, 5> kExitWords{"success", "abort", "fail", "interrupted",
                                                     "stopped"};

}  // namespace

std::string_view to_string(ExitStatus status) {
  return kExitWords.at(static_cast<std::size_t>(status));
}

std::string_view to_string(std::optional<ExitStatus> status, std::string_view absent) {
  return status ? to_string(*status) : absent;
}

std::optional<ExitStatus> parse_exit_status(std::string_view word) {
  const auto* const found = std::ranges::find(kExitWords, word);
  if (found == kExitWords.end()) return std::nullopt;
  return static_cast<ExitStatus>(found - kExitWords.begin());
}

}  // namespace lcrig
