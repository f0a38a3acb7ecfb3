// SPDX-License-Identifier: Apache-2.0
#include "drivers/wire_log.hpp"

#include "base/text.hpp"

namespace lcrig {

std::string quote_bytes(std::string_view bytes) {
  std::string out = "\"";
  for (const char c : bytes) {
    const auto u = static_cast<unsigned char>(c);
    if (c == '\n') {
      out += "\\n";
    } else if (c == '\r') {
      out += "\\r";
    } else if (c == '\t') {
      out += "\\t";
    } else if (c == '\\' || c == '"') {
      out += '\\';
      out += c;
    } else if (u < 0x20 || u >= 0x7f) {
      out += fmt::format("\\x{:02x}", u);
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string format_wire_header(const WireLogHeader& header) {
  std::string out(kWireLogFormat);
  out += '\n';
  // Header values must be one line, so they are escaped.
  for (const auto& [key, member] : kWireLogFields) {
    out += fmt::format("{}: {}\n", key, printable(header.*member));
  }
  return out;
}

std::string format_wire_entry(std::int64_t t_ns, bool to_instrument, std::string_view bytes) {
  return fmt::format("{} {} {}\n", t_ns, to_instrument ? '>' : '<', quote_bytes(bytes));
}

}  // namespace lcrig
