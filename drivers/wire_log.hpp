// SPDX-License-Identifier: Apache-2.0
// The wire log: everything that went over a port, as text (docs/wire-log.md). Written by
// RecordingTransport, played by ReplayTransport.
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
  bool to_instrument = false;  // true: '>', false: '<'
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
// Puts quotation marks around the bytes. Printable ASCII stays, the rest becomes \n \r \t \\ \"
// \xNN.
std::string quote_bytes(std::string_view bytes);

// Messages call the file `name`. `text` may be arbitrary bytes. Errors: invalid_request with the
// line and what was expected.
Result<WireLog> parse_wire_log(std::string_view text, std::string_view name);
Result<WireLog> load_wire_log(const std::string& path);

}  // namespace lcrig
