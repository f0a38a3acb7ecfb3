// SPDX-License-Identifier: Apache-2.0
// The wire log: everything that went over a port, as text. Format: docs/wire-log.md.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

struct WireLogHeader {
  WireLogHeader() = default;
  std::string instrument, firmware, date, conditions;
};

struct WireEntry {
  WireEntry() = default;
  std::int64_t t_ns = 0;  // since the start of the log
  bool to_instrument = false;  // '>', else '<'
  std::string bytes;
  int line = 0;  // in the file, from 1
};

struct WireLog {
  WireLog() = default;
  WireLogHeader header;
  std::vector<WireEntry> entries;
};

std::string format_wire_header(const WireLogHeader& header);
std::string format_wire_entry(std::int64_t t_ns, bool to_instrument, std::string_view bytes);
// Printable ASCII as it is, the rest as \n \r \t \\ \" \xNN, in quotation marks.
std::string quote_bytes(std::string_view bytes);

// `name` is what messages call the file. Errors: invalid_request with line and expectation; the
// text may be anything.
Result<WireLog> parse_wire_log(std::string_view text, std::string_view name);
Result<WireLog> load_wire_log(const std::string& path);

}  // namespace lcrig
