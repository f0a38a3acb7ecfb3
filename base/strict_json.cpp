// SPDX-License-Identifier: Apache-2.0
#include "base/strict_json.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <unordered_map>

#include "base/json_mistake.hpp"
#include "base/text.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

constexpr std::size_t kShownMax = 200;  // characters of one value of the file in a message
constexpr std::size_t kMessageMax = 2000;

std::string escape_pointer(std::string_view key) {
  std::string out;
  for (const char c : key) {
    if (c == '~') {
      out += "~0";
    } else if (c == '/') {
      out += "~1";
    } else {
      out += c;
    }
  }
  return out;
}

// Finds the line and column of each value. nlohmann's SAX interface reports values without
// positions. Each of its events is one token, so this class steps through the accepted text token
// by token.
class TokenFollower {
 public:
  explicit TokenFollower(std::string_view text) : text_(text) {
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
  }

  // Returns where the next value or key starts, and moves past it.
  TextPosition next() {
    skip_between();
    const TextPosition start = here_;
    if (at_ >= text_.size()) return start;
    const char c = text_[at_];
    if (c == '"') {
      skip_string();
    } else if (c == '{' || c == '[') {
      step();
    } else {
      while (at_ < text_.size() && !std::strchr(" \t\r\n,:{}[]\"/", text_[at_])) step();
    }
    return start;
  }

  TextPosition position_of(std::size_t byte) const {
    TextPosition p;
    const std::size_t first = text_.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
    for (std::size_t i = first; i < byte && i < text_.size(); ++i) advance(p, i);
    return p;
  }

  // nlohmann also accepts /* */ comments; the file formats allow only `//`.
  const std::optional<TextPosition>& block_comment() const { return block_comment_; }
  void skip_between() {
    while (at_ < text_.size()) {
      if (text_.substr(at_, 2) == "//") {
        while (at_ < text_.size() && !ends_line(text_, at_)) step();
      } else if (text_.substr(at_, 2) == "/*") {
        if (!block_comment_) block_comment_ = here_;
        const auto close = text_.find("*/", at_ + 2);
        const auto end = close == text_.npos ? text_.size() : close + 2;
        while (at_ < end) step();
      } else if (std::strchr(" \t\r\n,:}]", text_[at_])) {
        step();
      } else {
        return;
      }
    }
  }

 private:
  void advance(TextPosition& p, std::size_t at) const {
    if (ends_line(text_, at)) {
      ++p.line;
      p.column = 1;
    } else if ((static_cast<unsigned char>(text_[at]) & 0xC0U) != 0x80U) {  // not a continuation
                                                                            // byte
      ++p.column;
    }
  }
  void step() { advance(here_, at_++); }
  void skip_string() {
    step();
    while (at_ < text_.size() && text_[at_] != '"') {
      if (text_[at_] == '\\') step();
      if (at_ < text_.size()) step();
    }
    if (at_ < text_.size()) step();
  }

  std::string_view text_;
  std::size_t at_ = 0;
  TextPosition here_;
  std::optional<TextPosition> block_comment_;
};

// "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error ..." -> the rest.
std::string without_prefix(std::string what) {
  if (const auto at = what.find("] "); at != std::string::npos) what.erase(0, at + 2);
  if (what.starts_with("parse error at")) {
    if (const auto at = what.find(": "); at != std::string::npos) what.erase(0, at + 2);
  }
  return printable(what, kShownMax);
}

}  // namespace

struct JsonDocument::Data {
  struct Place {
    TextPosition key, value;
  };
  json root;
  std::string name, text;
  std::unordered_map<std::string, Place> places;
  std::vector<Duplicate> duplicates;
};

class JsonParser final : public nlohmann::json_sax<json> {
 public:
  JsonParser(std::string_view text, JsonDocument::Data& data)
      : text_(text), follower_(text), data_(data) {}

  Result<> run() {
    if (const auto mistake = find_encoding_mistake(text_)) return wrong_encoding(*mistake);
    const bool good = json::sax_parse(text_, this, json::input_format_t::json, true, true);
    follower_.skip_between();
    if (error_.empty() && follower_.block_comment()) {
      refuse(*follower_.block_comment(), "a /* comment, expected `//` comments only");
    }
    if (error_.empty()) refuse_steering();
    if (!error_.empty()) {
      Error error(Errc::invalid_request, error_);
      error.detail = excerpt(text_, error_at_);
      if (cut_off_ && has_text_below(text_, error_at_.line)) {
        error.detail += "\nthe first of possibly several: what follows it was not read";
      }
      return fail(std::move(error));
    }
    if (!good) return fail(Errc::bug, "{}: refused without a reason", data_.name);
    return {};
  }

  static JsonDocument document(std::shared_ptr<const JsonDocument::Data> data) {
    JsonDocument out;
    out.data_ = std::move(data);
    return out;
  }

  bool null() override { return value(nullptr); }
  bool boolean(bool v) override { return value(v); }
  bool number_integer(number_integer_t v) override { return value(v); }
  bool number_unsigned(number_unsigned_t v) override { return value(v); }
  bool number_float(number_float_t v, const string_t&) override { return value(v); }
  bool string(string_t& v) override { return value(std::move(v)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(json::object()); }
  bool start_array(std::size_t) override { return open(json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& v) override {
    Level& level = levels_.back();
    const TextPosition at = follower_.next();
    if (v.size() > kJsonKeyMax) {
      return refuse(at,
                    fmt::format("a key of {} bytes, expected at most {}", v.size(), kJsonKeyMax));
    }
    level.key = v;
    const std::string pointer = next_pointer();
    if (pointer.size() > kJsonPointerMax) {
      return refuse(at, fmt::format("keys of {} bytes above one another, expected at most {}",
                                    pointer.size(), kJsonPointerMax));
    }
    if (!level.keys.insert(v).second) {
      const TextPosition first = data_.places[pointer].key;
      const auto what =
          fmt::format("the key `{}` for the second time, expected once (first in line {})",
                      printable(v, kShownMax), first.line);
      constexpr std::size_t kMost = 100;  // nobody reads more of them
      if (data_.duplicates.size() < kMost) data_.duplicates.push_back({pointer, what, at});
      return true;
    }
    data_.places[pointer].key = at;
    return true;
  }

  bool parse_error(std::size_t position, const std::string&,
                   const json::exception& error) override {
    cut_off_ = true;
    if (const auto mistake = find_json_mistake(text_)) {
      return refuse(follower_.position_of(mistake->at), mistake->words);
    }
    refuse_steering();
    if (!error_.empty()) return false;
    const std::size_t byte = position > 0 ? position - 1 : 0;
    return refuse(follower_.position_of(byte), without_prefix(error.what()));
  }

 private:
  // Is reported alone, because the text means nothing until it is read in the right encoding.
  Result<> wrong_encoding(const JsonMistake& mistake) {
    refuse(follower_.position_of(mistake.at), mistake.words);
    Error error(Errc::invalid_request, error_);
    const auto ascii = ascii_of_utf16(text_);
    error.detail = excerpt(ascii ? std::string_view(*ascii) : text_, error_at_);
    return fail(std::move(error));
  }

  // nlohmann refuses control characters only in strings, and in its own words; comments need it
  // too.
  void refuse_steering() {
    std::string_view rest = text_;
    if (rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
    while (!rest.empty()) {
      const std::string_view before = rest;
      const char32_t c = take_character(rest);
      if (c == '\n' || c == '\r' || c == '\t' || (c != kNotUtf8 && !is_steering(c))) continue;
      const auto bytes = before.substr(0, before.size() - rest.size());
      refuse(follower_.position_of(text_.size() - before.size()),
             fmt::format("the character {}, expected UTF-8 text without control characters",
                         printable(bytes)));
      return;
    }
  }

  struct Level {
    json* container = nullptr;
    std::string pointer;
    std::string key;
    std::set<std::string> keys;
  };

  std::string next_pointer() const {
    if (levels_.empty()) return {};
    const Level& level = levels_.back();
    if (level.container->is_array()) {
      return fmt::format("{}/{}", level.pointer, level.container->size());
    }
    return level.pointer + "/" + escape_pointer(level.key);
  }

  json* place(json v) {
    const std::string pointer = next_pointer();
    data_.places[pointer].value = follower_.next();
    if (levels_.empty()) return &(data_.root = std::move(v));
    json& container = *levels_.back().container;
    if (container.is_array()) return &container.emplace_back(std::move(v));
    return &(container[levels_.back().key] = std::move(v));
  }

  template <class V>
  bool value(V&& v) {
    place(json(std::forward<V>(v)));
    return count();
  }

  bool count() {
    if (++values_ <= kJsonValuesMax) return true;
    return refuse(follower_.next(),
                  fmt::format("more than {} values, expected fewer", kJsonValuesMax));
  }

  bool open(json container) {
    Level level;
    level.pointer = next_pointer();
    level.container = place(std::move(container));
    if (levels_.size() >= kJsonDepthMax) {
      return refuse(data_.places[level.pointer].value,
                    fmt::format("more than {} levels of nesting", kJsonDepthMax));
    }
    levels_.push_back(std::move(level));
    return count();
  }

  bool close() {
    levels_.pop_back();
    return true;
  }

  bool refuse(TextPosition at, const std::string& why) {
    if (!error_.empty()) return false;
    error_at_ = at;
    const std::string pointer = levels_.empty() ? "" : levels_.back().pointer;
    error_ = fmt::format("{}:{}:{} {}: {}", data_.name, at.line, at.column,
                         pointer.empty() ? "/" : printable(pointer, kShownMax),
                         printable(why, kMessageMax));
    return false;
  }

  std::string_view text_;
  TokenFollower follower_;
  JsonDocument::Data& data_;
  std::vector<Level> levels_;
  std::size_t values_ = 0;
  bool cut_off_ = false;  // parsing stopped before the end
  std::string error_;
  TextPosition error_at_;
};

Result<JsonDocument> JsonDocument::parse(std::string_view text, std::string name) {
  if (text.size() > kJsonSizeMax) {
    return fail(Errc::invalid_request, "{}:1:1 /: {} bytes, expected at most {}", name, text.size(),
                kJsonSizeMax);
  }
  auto data = std::make_shared<Data>();
  data->name = printable(name, kShownMax);
  data->text = text;
  JsonParser parser(text, *data);
  if (auto r = parser.run(); !r) return fail(r.error());
  return JsonParser::document(std::move(data));
}

const json& JsonDocument::root() const {
  return data_->root;
}
const std::string& JsonDocument::name() const {
  return data_->name;
}
std::string JsonDocument::number_text(const std::string& pointer) const {
  const auto text =
      std::string_view(data_->text).substr(byte_of(data_->text, value_position(pointer)));
  return std::string(text.substr(0, text.find_first_not_of("+-.0123456789eE")));
}
const std::vector<JsonDocument::Duplicate>& JsonDocument::duplicates() const {
  return data_->duplicates;
}
std::string_view JsonDocument::text() const {
  return data_->text;
}
TextPosition JsonDocument::value_position(const std::string& pointer) const {
  const auto it = data_->places.find(pointer);
  return it == data_->places.end() ? TextPosition{} : it->second.value;
}
TextPosition JsonDocument::key_position(const std::string& pointer) const {
  const auto it = data_->places.find(pointer);
  return it == data_->places.end() ? TextPosition{} : it->second.key;
}

namespace {

// Reads the bytes that are available; 0: the end. Waits for a pipe, but not for ever.
ssize_t read_next(int fd, std::span<char> into) {
  constexpr int kPatience_ms = 10'000;
  while (true) {
    const ssize_t n = ::read(fd, into.data(), into.size());
    if (n >= 0 || (errno != EAGAIN && errno != EINTR)) return n;
    pollfd one{fd, POLLIN, 0};
    if (::poll(&one, 1, kPatience_ms) == 0) {
      errno = ETIMEDOUT;
      return -1;
    }
  }
}

}  // namespace

Result<std::string> read_text_file(const std::string& path) {
  // Without O_NONBLOCK opening a pipe would wait until somebody writes into it.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return fail(Errc::io, "{}: cannot open: {}", path, std::strerror(errno));
  std::string text;
  std::array<char, 16384> buffer{};
  ssize_t n = 0;
  while ((n = read_next(fd, buffer)) > 0 && text.size() <= kJsonSizeMax) {
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
  const int error = errno;
  ::close(fd);
  if (n < 0) return fail(Errc::io, "{}: cannot read: {}", path, std::strerror(error));
  if (text.size() > kJsonSizeMax) {
    return fail(Errc::invalid_request, "{}: more than {} bytes", path, kJsonSizeMax);
  }
  return text;
}

Result<> require_plain_file(const std::string& path) {
  std::error_code unknown;  // ignored: opening the file reports the reason
  const auto status = std::filesystem::status(path, unknown);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) return {};
  return fail(Errc::invalid_request, "{}: is {}; name a file", path,
              std::filesystem::is_directory(status) ? "a folder" : "a pipe or a device");
}

Result<JsonDocument> load_json(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return fail(text.error());
  return JsonDocument::parse(*text, path);
}

}  // namespace lcrig
