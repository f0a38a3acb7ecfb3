// SPDX-License-Identifier: Apache-2.0
// Property: a wire log that is read, written and read again stays the same.
#include "tests/support/wire_log_reader.hpp"

#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {

namespace {

std::string written(const WireLog& log) {
  std::string out = format_wire_header(log.header);
  for (const WireEntry& e : log.entries) out += format_wire_entry(e.t_ns, e.to_instrument, e.bytes);
  return out;
}

}  // namespace

void read_wire_log(std::string_view input) {
  const auto log = parse_wire_log(input, "fuzz.wire");
  if (!log) return require_good_message(log.error());
  const std::string text = written(*log);
  const auto again = parse_wire_log(text, "again.wire");
  require(again.has_value(), again ? "" : "our own text is refused: " + again.error().what);
  require(again->entries.size() == log->entries.size(), "another number of entries");
  for (std::size_t i = 0; i < log->entries.size(); ++i) {
    const WireEntry &a = log->entries[i], &b = again->entries[i];
    require(a.t_ns == b.t_ns && a.to_instrument == b.to_instrument, "another time or direction");
    require(a.bytes == b.bytes, "other bytes");
  }
  require(written(*again) == text, "the text changes each time");
}

}  // namespace lcrig::fuzz
