// SPDX-License-Identifier: Apache-2.0
// File names of wire logs. The real rig makes them, and `lcrig doctor --bundle` tells by them which
// logs contain measured values.
#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace lcrig {

enum class WireLogOf { run, looks };  // looks: the questions of an idle daemon

// "lcr-1769853600.wire", "lcr-looks-1769853600.wire"
inline std::string wire_log_name(std::string_view instrument, WireLogOf what,
                                 std::int64_t unix_ns) {
  return fmt::format("{}{}{}.wire", instrument, what == WireLogOf::looks ? "-looks-" : "-",
                     unix_ns);
}
inline bool is_wire_log(std::string_view name) {
  return name.ends_with(".wire");
}
inline bool is_wire_log_of_looks(std::string_view name) {
  return is_wire_log(name) && name.find("-looks-") != name.npos;
}

}  // namespace lcrig
