// SPDX-License-Identifier: Apache-2.0
// The syntax of frame-link/1 lines: framing, words, fields, numbers. Used by codec.hpp, which knows
// their meaning.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.hpp"

namespace lcrig::frame_link {

constexpr std::size_t kMaxLine = 65536;  // bytes, including the LF
constexpr std::size_t kMaxFields = 100;  // bounds the search for duplicate keys

// One message. Its views point into the parsed text.
struct Line {
  std::optional<std::int64_t> number;  // of "#17 MOVE" and of "OK #17"
  std::string_view word;
  std::vector<std::pair<std::string_view, std::string_view>> fields;  // values still quoted

  std::optional<std::string_view> find(std::string_view key) const;
  std::string text(std::string_view key) const;  // unquoted; empty when absent
  // Errors: garbled (absent, or not a finite decimal number).
  Result<double> number_of(std::string_view key) const;
  // nullopt when absent. Errors: garbled.
  Result<std::optional<double>> optional_number(std::string_view key) const;
  bool flag(std::string_view key) const { return find(key) == "1"; }
};

// Errors: garbled. `text` is one line without its LF.
Result<Line> parse_line(std::string_view text);
// The number of a command that does not parse, if the number itself can be read.
std::optional<std::int64_t> number_of_bad_line(std::string_view text);

// Cuts a byte stream into lines. A line longer than kMaxLine is dropped up to its LF and counted.
class LineSplitter {
 public:
  void feed(std::string_view bytes) { buffer_.append(bytes); }
  // The next complete line without LF or CR LF; valid until the next call of any member.
  std::optional<std::string_view> next();
  std::size_t dropped() const { return dropped_; }

 private:
  std::string buffer_;
  std::size_t begin_ = 0;  // position of the first byte not yet returned
  std::size_t searched_ = 0;  // there is no LF before this position
  std::size_t dropped_ = 0;
  bool skipping_ = false;
};

// Text to a number. Errors: garbled (not finite, not decimal, something after it).
Result<double> parse_number(std::string_view text);
// `value` must be finite. Appends the shortest form without an exponent that reads back the same.
void append_number(std::string& out, double value);
void append_integer(std::string& out, std::int64_t value);
std::string_view excerpt(std::string_view text);  // for messages

// Builds one line. Text is quoted, control characters become blanks.
class Writer {
 public:
  explicit Writer(std::string_view word) : out_(word) {}
  Writer(std::int64_t number, std::string_view word) : out_("#") {
    append_integer(out_, number);
    out_.append(" ").append(word);
  }
  Writer(std::string_view word, std::int64_t number) : out_(word) {
    out_ += " #";
    append_integer(out_, number);
  }
  Writer& number(std::string_view key, double value) {
    append_number(begin(key), value);
    return *this;
  }
  Writer& number(std::string_view key, std::optional<double> value) {
    return value ? number(key, *value) : *this;
  }
  Writer& integer(std::string_view key, std::int64_t value) {
    append_integer(begin(key), value);
    return *this;
  }
  Writer& flag(std::string_view key, bool value) { return integer(key, value ? 1 : 0); }
  Writer& text(std::string_view key, std::string_view value) {
    std::string& out = begin(key);
    out += '"';
    for (const char c : value.substr(0, 1000)) {
      if (c == '"' || c == '\\') out += '\\';
      out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
    out += '"';
    return *this;
  }
  std::string line() { return std::move(out_ += '\n'); }

 private:
  std::string& begin(std::string_view key) { return out_.append(" ").append(key).append("="); }
  std::string out_;
};

}  // namespace lcrig::frame_link
