// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/line.hpp"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>

#include "base/number.hpp"
#include "base/text.hpp"

namespace lcrig::frame_link {

std::string_view excerpt(std::string_view text) {
  return text.substr(0, 60);
}

Result<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  const auto value = number_from<double>(text);
  if (value) return *value;
  return fail(Errc::garbled, "'{}' is not a finite decimal number", printable(excerpt(text)));
}

void append_number(std::string& out, double value) {
  assert(std::isfinite(value));
  char buffer[512];  // the longest double has about 330 digits
  const auto r = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed);
  out.append(buffer, r.ptr);
}

void append_integer(std::string& out, std::int64_t value) {
  char buffer[24];
  const auto r = std::to_chars(buffer, buffer + sizeof buffer, value);
  out.append(buffer, r.ptr);
}

namespace {

// The end of the token that starts at `from`, i.e. a blank outside quotes. npos: unclosed quote.
std::size_t token_end(std::string_view text, std::size_t from) {
  bool quoted = false;
  for (std::size_t i = from; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\') {
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ' ' && !quoted) {
      return i;
    }
  }
  return quoted ? std::string_view::npos : text.size();
}

// Removes and returns the next token of `text`: empty at the end, nullopt for an unclosed quote.
std::optional<std::string_view> take_token(std::string_view& text) {
  const auto begin = std::min(text.find_first_not_of(' '), text.size());
  const auto end = token_end(text, begin);
  if (end == std::string_view::npos) return std::nullopt;
  const auto token = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return token;
}

Result<std::int64_t> command_number(std::string_view token) {
  const auto value = number_from<std::int64_t>(token.substr(1));
  if (!value || *value < 0) {
    return fail(Errc::garbled, "'{}' is not a command number", printable(excerpt(token)));
  }
  return *value;
}

// Refuses keys with unusual characters. A key with a spoiled byte would be ignored as unknown, and
// its value would be missing without notice.
bool is_key(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

Result<> add_field(Line& line, std::string_view token) {
  const auto equals = token.find('=');
  if (equals == 0 || equals == std::string_view::npos) {
    return fail(Errc::garbled, "'{}' is not key=value", printable(excerpt(token)));
  }
  const auto key = token.substr(0, equals);
  if (!is_key(key)) return fail(Errc::garbled, "'{}' is no key", printable(excerpt(key)));
  if (line.find(key)) return fail(Errc::garbled, "'{}' twice", printable(excerpt(key)));
  if (line.fields.size() == kMaxFields) {
    return fail(Errc::garbled, "more than {} fields", kMaxFields);
  }
  line.fields.emplace_back(key, token.substr(equals + 1));
  return {};
}

Result<> add_token(Line& line, std::string_view token) {
  if (!token.starts_with('#')) {
    if (!line.word.empty()) return add_field(line, token);
    line.word = token;
    return {};
  }
  if (line.number || !line.fields.empty()) {
    return fail(Errc::garbled, "a second command number '{}'", printable(excerpt(token)));
  }
  return keep(command_number(token), line.number);
}

}  // namespace

std::optional<std::string_view> Line::find(std::string_view key) const {
  for (const auto& [k, v] : fields) {
    if (k == key) return v;
  }
  return std::nullopt;
}

std::string Line::text(std::string_view key) const {
  const auto raw = find(key).value_or(std::string_view());
  std::string out;
  out.reserve(raw.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (raw[i] == '"') continue;
    if (raw[i] == '\\' && i + 1 < raw.size()) ++i;
    out += raw[i];
  }
  return out;
}

Result<double> Line::number_of(std::string_view key) const {
  const auto raw = find(key);
  if (!raw) return fail(Errc::garbled, "{} lacks {}", printable(excerpt(word)), key);
  auto value = parse_number(*raw);
  if (!value) return fail(Errc::garbled, "{}: {}", key, value.error().what);
  return value;
}

Result<std::optional<double>> Line::optional_number(std::string_view key) const {
  if (!find(key)) return std::optional<double>();
  auto value = number_of(key);
  if (!value) return fail(value.error());
  return std::optional<double>(*value);
}

Result<Line> parse_line(std::string_view text) {
  if (text.size() >= kMaxLine) return fail(Errc::garbled, "a line of {} bytes", text.size());
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (std::ranges::any_of(text, is_control)) {
    return fail(Errc::garbled, "control characters in '{}'", printable(excerpt(text)));
  }
  Line line;
  for (auto rest = text;;) {
    const auto token = take_token(rest);
    if (!token) return fail(Errc::garbled, "an open quote in '{}'", printable(excerpt(text)));
    if (token->empty()) break;
    auto added = add_token(line, *token);
    if (!added) return fail(added.error());
  }
  if (line.word.empty()) return fail(Errc::garbled, "a line without a word");
  return line;
}

std::optional<std::int64_t> number_of_bad_line(std::string_view text) {
  const auto token = take_token(text);
  if (!token || !token->starts_with('#')) return std::nullopt;
  const auto number = command_number(*token);
  return number ? std::optional(*number) : std::nullopt;
}

std::optional<std::string_view> LineSplitter::next() {
  for (;;) {
    const auto end = buffer_.find('\n', std::max(begin_, searched_));
    if (end == std::string::npos) break;
    std::string_view line(buffer_.data() + begin_, end - begin_);
    begin_ = searched_ = end + 1;
    const bool was_skipping = std::exchange(skipping_, false);
    if (was_skipping) continue;
    if (line.size() >= kMaxLine) {
      ++dropped_;
      continue;
    }
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }
  buffer_.erase(0, begin_);
  begin_ = 0;
  if (buffer_.size() >= kMaxLine) {
    if (!skipping_) ++dropped_;
    skipping_ = true;
    buffer_.clear();
  }
  searched_ = buffer_.size();
  return std::nullopt;
}

}  // namespace lcrig::frame_link
