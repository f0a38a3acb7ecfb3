// SPDX-License-Identifier: Apache-2.0
// Reads wire logs (docs/wire-log.md), for the tests that play them.
#pragma once

#include <charconv>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "drivers/wire_log.hpp"

namespace lcrig {

struct WireEntry {
  std::int64_t t_ns = 0;  // since the start of the log
  bool to_instrument = false;  // true: '>', false: '<'
  std::string bytes;
  int line = 0;  // in the file, from 1
};

struct WireLog {
  WireLogHeader header;
  std::vector<WireEntry> entries;
};

namespace wire_log {

constexpr std::size_t kMaxFile = 256U << 20U;  // bytes

inline std::optional<char> unescape_simple(char c) {
  switch (c) {
    case 'n': return '\n';
    case 'r': return '\r';
    case 't': return '\t';
    case '\\': return '\\';
    case '"': return '"';
    default: return std::nullopt;
  }
}

inline std::optional<char> unescape_hex(std::string_view two) {
  unsigned value = 0;
  const char* end = two.data() + two.size();
  if (two.size() != 2) return std::nullopt;
  const auto r = std::from_chars(two.data(), end, value, 16);
  if (r.ec != std::errc() || r.ptr != end) return std::nullopt;
  return static_cast<char>(value);
}

// Takes `text` with its quotation marks. Nothing may follow the closing one.
inline std::optional<std::string> unquote(std::string_view text) {
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return std::nullopt;
  text = text.substr(1, text.size() - 2);
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || static_cast<unsigned char>(c) < 0x20) return std::nullopt;
    if (c != '\\') {
      out += c;
      continue;
    }
    if (++i == text.size()) return std::nullopt;
    const bool hex = text[i] == 'x';
    const auto byte = hex ? unescape_hex(text.substr(i + 1, 2)) : unescape_simple(text[i]);
    if (!byte) return std::nullopt;
    out += *byte;
    if (hex) i += 2;
  }
  return out;
}

class WireLogParser {
 public:
  explicit WireLogParser(std::string_view name) : name_(name) {}

  Result<> line(std::string_view text) {
    ++number_;
    if (text.ends_with('\r')) text.remove_suffix(1);
    if (number_ == 1) {
      if (text == kWireLogFormat) return {};
      return expected(text, "the first line to be wire-log/1");
    }
    if (text.empty() || text.front() == '#') return {};
    if (text.front() >= '0' && text.front() <= '9') return entry(text);
    return log_.entries.empty() ? field(text) : expected(text, "TIME > \"BYTES\" or TIME < …");
  }

  Result<WireLog> finish() && {
    if (number_ == 0) return expected("", "the first line to be wire-log/1");
    return std::move(log_);
  }

 private:
  tl::unexpected<Error> expected(std::string_view text, std::string_view what) const {
    return fail(Errc::invalid_request, "{}:{}: expected {}, found \"{}\"", name_, number_, what,
                printable(text.substr(0, 80)));
  }

  Result<> field(std::string_view text) {
    for (const auto& [key, member] : kWireLogFields) {
      if (!text.starts_with(key) || !text.substr(key.size()).starts_with(": ")) continue;
      log_.header.*member = text.substr(key.size() + 2);
      return {};
    }
    return expected(text, "instrument:, firmware:, date:, conditions: or TIME > \"BYTES\"");
  }

  Result<> entry(std::string_view text) {
    WireEntry out;
    const auto r = std::from_chars(text.data(), text.data() + text.size(), out.t_ns);
    if (r.ec != std::errc()) return expected(text, "a time in ns that fits 64 bits");
    const std::string_view rest = text.substr(static_cast<std::size_t>(r.ptr - text.data()));
    if (!rest.starts_with(" > ") && !rest.starts_with(" < ")) return expected(text, "TIME > or <");
    if (!log_.entries.empty() && out.t_ns < log_.entries.back().t_ns) {
      return expected(text, "times that do not run backwards");
    }
    auto bytes = unquote(rest.substr(3));
    if (!bytes) return expected(text, "bytes in quotation marks with \\n \\r \\t \\\\ \\\" \\xNN");
    out.to_instrument = rest[1] == '>';
    out.bytes = std::move(*bytes);
    out.line = number_;
    log_.entries.push_back(std::move(out));
    return {};
  }

  std::string name_;
  int number_ = 0;
  WireLog log_;
};

}  // namespace wire_log

// Messages call the file `name`. `text` may be arbitrary bytes. Errors: invalid_request with the
// line and what was expected.
inline Result<WireLog> parse_wire_log(std::string_view text, std::string_view name) {
  wire_log::WireLogParser parser(name);
  while (!text.empty()) {
    const auto end = text.find('\n');
    Result<> ok = parser.line(text.substr(0, end));
    if (!ok) return fail(ok.error());
    text = end == text.npos ? std::string_view() : text.substr(end + 1);
  }
  return std::move(parser).finish();
}

inline Result<WireLog> load_wire_log(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return fail(Errc::io, "{}: cannot be opened", path);
  const auto size = static_cast<std::streamoff>(file.tellg());
  if (size < 0 || static_cast<std::size_t>(size) > wire_log::kMaxFile) {
    return fail(Errc::invalid_request, "{}: not a file, or larger than 256 MiB", path);
  }
  std::string text(static_cast<std::size_t>(size), '\0');
  file.seekg(0);
  if (!file.read(text.data(), size)) return fail(Errc::io, "{}: cannot be read", path);
  return parse_wire_log(text, path);
}

}  // namespace lcrig
