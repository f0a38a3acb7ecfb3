// SPDX-License-Identifier: Apache-2.0
#include "base/json_mistake.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

#include "base/number.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}
bool is_word(char c) {
  return is_digit(c) || is_letter(c) || c == '.' || c == '+' || c == '-';
}

// Walks through the text by the grammar of JSON, up to the first mistake.
class Walk {
 public:
  explicit Walk(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  }

  std::optional<JsonMistake> find() {
    while (!mistake_) {
      skip_blanks();
      if (at_ >= text_.size()) {
        at_end();
        break;
      }
      token();
      token_end_ = at_;
    }
    return mistake_;
  }

 private:
  enum class Expect { value, first_value, key, first_key, colon, comma, nothing };
  struct Open {
    char bracket;
    std::size_t at;
  };

  char now() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  long line_of(std::size_t at) const {
    long line = 1;
    for (std::size_t i = 0; i < at; ++i) line += ends_line(text_, i) ? 1 : 0;
    return line;
  }
  void wrong(std::size_t at, std::string words) { mistake_ = JsonMistake{at, std::move(words)}; }

  void skip_blanks() {
    while (at_ < text_.size()) {
      if (text_.substr(at_, 2) == "//") {
        at_ = next_line(text_, at_);
      } else if (std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) {
        ++at_;
      } else {
        return;
      }
    }
  }

  void at_end() {
    if (open_.empty() && expect_ == Expect::value) {
      wrong(0, "the file is empty, expected an object: { ... }");
    } else if (!open_.empty()) {
      const bool object = open_.back().bracket == '{';
      wrong(token_end_,
            fmt::format("the file ends, but the {} that begins in line {} is not "
                        "closed: a `{}` is missing",
                        object ? "object" : "list", line_of(open_.back().at), object ? '}' : ']'));
    }
  }

  void token() {
    const char c = now();
    if (text_.substr(at_, 2) == "/*") {
      return wrong(at_, "a /* comment, expected `//` comments only");
    }
    if (c == '#') return wrong(at_, "a comment begins with `//`, not with `#`");
    if (c == '\'' && behind_number() && at_ == number_end_) return grouped_number();  // 1'000
    if (c == '\'') return wrong(at_, "keys and texts stand in double quotes: \"...\"");
    if (const auto curly = curly_quote(at_); !curly.empty()) {
      return wrong(at_, fmt::format("`{}` is no quote of JSON: keys and texts stand in straight "
                                    "double quotes: \"...\"",
                                    curly));
    }
    if (text_.substr(at_, 2) == "\xC2\xA0") {
      return wrong(at_, "a blank that must not be broken (U+00A0), expected an ordinary one");
    }
    if (const auto dash = typographic_dash(); !dash.empty()) {
      return wrong(at_,
                   fmt::format("`{}` is no minus sign of JSON: the `-` of the keyboard is", dash));
    }
    switch (expect_) {
      case Expect::nothing: return wrong(at_, "something follows the end of the file's object");
      case Expect::colon: return colon();
      case Expect::comma: return comma();
      case Expect::key:
      case Expect::first_key: return key();
      case Expect::value:
      case Expect::first_value: return value();
    }
  }

  void colon() {
    if (now() == '=') return wrong(at_, "a `:` stands between a key and its value, not `=`");
    if (now() != ':') return wrong(last_end_, "a `:` is missing behind the key");
    ++at_;
    expect_ = Expect::value;
  }

  void comma() {
    const char c = now();
    if (c == ',') {
      comma_at_ = at_++;
      expect_ = open_.back().bracket == '{' ? Expect::key : Expect::value;
    } else if (c == '}' || c == ']') {
      close();
    } else if (c == ';') {
      wrong(at_, "`,` stands between two entries, not `;`");
    } else if (c == ':' && !open_.empty() && open_.back().bracket == '[' && last_is_text_) {
      wrong(text_at_, fmt::format("a `]` is missing before this key: the list that begins in line "
                                  "{} is not closed",
                                  line_of(open_.back().at)));
    } else if (c == ':') {
      wrong(at_, "a `:` stands only behind a key");
    } else if (last_is_number_ && (is_letter(c) || c == '%' || begins_unit())) {
      wrong(at_, "a number has no unit; it belongs to the key, as in \"force_N\": 1.5");
    } else if (last_is_number_ && std::string_view("*/^").find(c) != std::string_view::npos) {
      wrong(number_end_ - last_word_.size(), "this is a calculation, expected its result alone");
    } else if (last_is_number_ && c == '.' && text_.substr(at_, 2) == "..") {
      wrong(at_, "the two ends of a range stand in a list, with a `,` between them: [0, 1.5]");
    } else if (last_is_number_ && is_digit(c) && open_.back().bracket == '{' &&
               line_of(number_end_) == line_of(at_)) {
      grouped_number();  // 1 000; within a list this means a missing comma
    } else if (last_is_text_ && is_letter(c) && at_ == last_end_) {  // "contact, "speed"
      wrong(text_at_, "a `\"` is missing: the text that begins here goes up to the next one");
    } else {
      wrong(last_end_, "a `,` is missing here");
    }
  }

  void key() {
    const char c = now();
    if (c == '"') return text(Expect::colon);
    if (c == '}' && expect_ == Expect::first_key) return close();
    if (c == '}' || c == ']') return wrong(comma_at_, after_last());
    if (c == ',' && expect_ == Expect::first_key) {
      return wrong(at_, "a `,` before the first entry: remove it");
    }
    if (c == ',') return wrong(at_, "two commas without an entry between them");
    if (is_digit(c) && last_is_number_ && comma_at_ + 1 == at_) return decimal_comma(take_word());
    const bool first = expect_ == Expect::first_key;
    const auto word = take_word();
    const bool number = !word.empty() && (is_digit(word[0]) || word[0] == '-');
    skip_blanks();
    if (first && number && now() != ':') {
      return wrong(open_.back().at, "a list stands in square brackets: [ ... ]");
    }
    wrong(word_at_, word.empty() ? "a key in double quotes is missing here"
                                 : fmt::format("a key stands in double quotes: \"{}\"", word));
  }

  void value() {
    const char c = now();
    if (c == '{' || c == '[') {
      open_.push_back({c, at_++});
      expect_ = c == '{' ? Expect::first_key : Expect::first_value;
    } else if (c == '"') {
      text(after_value());
    } else if (c == ']' && expect_ == Expect::first_value) {
      close();
    } else if (c == '}' || c == ']' || c == ',') {
      const bool in_list = !open_.empty() && open_.back().bracket == '[';
      const bool trailing = c == ']' && in_list;
      wrong(trailing ? comma_at_ : at_, trailing ? after_last() : "a value is missing here");
    } else {
      bare(take_word());
    }
  }

  static std::string after_last() { return "a `,` behind the last entry: remove it"; }
  Expect after_value() const { return open_.empty() ? Expect::nothing : Expect::comma; }

  bool behind_number() const { return expect_ == Expect::comma && last_is_number_; }

  // Reports a number whose digits are grouped by apostrophes or blanks.
  void grouped_number() {
    const std::size_t begin = number_end_ - last_word_.size();
    while (at_ < text_.size() && (is_word(now()) || now() == '\'' || now() == ' ')) ++at_;
    auto all = text_.substr(begin, std::min<std::size_t>(at_ - begin, 40));
    while (all.ends_with(' ')) all.remove_suffix(1);
    wrong(begin, fmt::format("`{}`: the digits of a number stand side by side", all));
  }

  // The typographic quote at `at`; "" when there is none.
  std::string_view curly_quote(std::size_t at) const {
    for (const std::string_view quote : {"\u201C", "\u201D", "\u201E", "\u201F", "\u2018", "\u2019",
                                         "\u201A", "\u00AB", "\u00BB"}) {
      if (text_.substr(at, quote.size()) == quote) return quote;
    }
    return {};
  }

  // True at the first character of a unit that is not ASCII: µm, °C, Ω.
  bool begins_unit() const {
    for (const std::string_view sign : {"\u00B5", "\u03BC", "\u00B0", "\u03A9", "\u2126"}) {
      if (text_.substr(at_, sign.size()) == sign) return true;
    }
    return false;
  }

  // The minus sign or dash of a word processor at this place; "" when there is none.
  std::string_view typographic_dash() const {
    for (const std::string_view dash :
         {"\u2212", "\u2010", "\u2011", "\u2012", "\u2013", "\u2014"}) {
      if (text_.substr(at_, dash.size()) == dash) return dash;
    }
    return {};
  }

  // A number, true, false or null; or something that should be in quotes.
  void bare(std::string_view word) {
    last_is_number_ = last_is_text_ = false;
    if (word.empty() && now() == '$') {
      const std::size_t dollar = at_++;
      const auto name = take_word();
      return wrong(dollar, fmt::format("a reference stands in double quotes: \"${}\"", name));
    }
    if (word.empty() && now() == '(') {
      return wrong(at_, "a list stands in square brackets: [ ... ]");
    }
    if (word.empty() && now() == '<' && open_.empty()) {
      return wrong(at_, "this is no JSON: with `<` begins a web page, or XML");
    }
    if (word.empty()) return wrong(at_, "this begins no value");
    const bool number = is_digit(word[0]) || word[0] == '-' || word[0] == '+' || word[0] == '.';
    if (number) return this->number(word);
    if (word != "true" && word != "false" && word != "null") {
      const std::string small = lower_case(word);
      if (small == "true" || small == "false" || small == "null" || small == "none") {
        return wrong(word_at_,
                     fmt::format("`{}`: JSON writes {}", word, small == "none" ? "null" : small));
      }
      for (const auto& [said, meant] : {std::pair("yes", "true"), std::pair("on", "true"),
                                        std::pair("no", "false"), std::pair("off", "false")}) {
        if (small == said) return wrong(word_at_, fmt::format("`{}`: JSON writes {}", word, meant));
      }
      if (small == "nan" || small == "inf" || small == "infinity") {
        return wrong(word_at_, fmt::format("`{}` is no number that a file can hold", word));
      }
      return wrong(word_at_, fmt::format("a text stands in double quotes: \"{}\"", word));
    }
    last_end_ = at_;
    expect_ = after_value();
  }

  void number(std::string_view word) {
    std::size_t i = word[0] == '-' ? 1 : 0;
    const auto digits = [&] {
      const std::size_t from = i;
      while (i < word.size() && is_digit(word[i])) ++i;
      return i - from;
    };
    const std::size_t first = i, before_point = digits();
    if (before_point == 0) {
      return wrong(word_at_, fmt::format("`{}`: a number begins with a digit", word));
    }
    if (i < word.size() && (word[i] == 'x' || word[i] == 'X')) {
      return wrong(word_at_, fmt::format("`{}`: a number is written with decimal digits", word));
    }
    if (before_point > 1 && word[first] == '0') {
      if (comma_at_ > 0 && comma_at_ == number_end_ && comma_at_ + 1 == word_at_) {
        return decimal_comma(word);  // [1,000]
      }
      return wrong(word_at_, fmt::format("`{}`: a number does not begin with 0", word));
    }
    if (i < word.size() && word[i] == '.') {
      ++i;
      if (digits() == 0) {
        return wrong(word_at_, fmt::format("`{}`: a digit is missing behind the point", word));
      }
    }
    if (i < word.size() && (word[i] == 'e' || word[i] == 'E')) {
      const std::size_t e = i++;
      if (i < word.size() && (word[i] == '+' || word[i] == '-')) ++i;
      if (digits() == 0) i = e;
    }
    if (i < word.size()) {
      return wrong(word_at_, fmt::format("`{}` is no number; a unit belongs to the key, as in "
                                         "\"force_N\": 1.5",
                                         word));
    }
    const bool whole = at_ - word_at_ == word.size(), small = word.find('-', 1) != word.npos;
    if (whole && !small && !number_from<double>(word)) {
      return wrong(word_at_, fmt::format("`{}` is beyond the largest number, 1.8e308", word));
    }
    last_is_number_ = true;
    last_word_ = word;
    last_end_ = number_end_ = at_;
    expect_ = after_value();
  }

  void decimal_comma(std::string_view rest) {
    const std::size_t begin = comma_at_ - last_word_.size();
    const auto text = fmt::format("{},{}", last_word_, rest);
    const auto words = comma_words(text);
    wrong(begin, fmt::format("`{}`: {}", text, words.empty() ? "a number has no `,`" : words));
  }

  // Reads what follows a backslash. False: it is not an escape.
  bool escape() {
    const std::size_t begin = at_ - 1;
    if (now() != 'u') {
      if (std::string_view("\"\\/bfnrt").find(now()) != std::string_view::npos) return true;
      wrong(begin, "`\\` begins an escape; a backslash itself is written `\\\\`");
      return false;
    }
    const auto code = hex_behind(at_);
    if (!code) {
      wrong(begin, "behind `\\u` stand four digits of 0 to 9 and a to f, as in \\u00b5");
      return false;
    }
    constexpr unsigned kHigh = 0xD800, kLow = 0xDC00, kEnd = 0xE000;
    if (*code < kHigh || *code >= kEnd) return true;
    const auto other = text_.substr(at_ + 5, 2) == "\\u" ? hex_behind(at_ + 6) : std::nullopt;
    if (*code < kLow && other && *other >= kLow && *other < kEnd) {
      at_ += 6;
      return true;
    }
    wrong(begin, fmt::format("`{}` is half of a character: write the character itself",
                             text_.substr(begin, 6)));
    return false;
  }

  // The value of the four hex digits after the `u` at `at`.
  std::optional<unsigned> hex_behind(std::size_t at) const {
    unsigned out = 0;
    for (std::size_t i = at + 1; i <= at + 4; ++i) {
      if (i >= text_.size() || std::isxdigit(static_cast<unsigned char>(text_[i])) == 0) return {};
      const char c = text_[i];
      out = out * 16 + static_cast<unsigned>(is_digit(c) ? c - '0' : (c | 0x20) - 'a' + 10);
    }
    return out;
  }

  void text(Expect next) {
    const std::size_t begin = text_at_ = at_++;
    last_is_number_ = false;
    last_is_text_ = true;
    std::size_t curly_at = 0;
    while (at_ < text_.size() && text_[at_] != '"') {
      if (curly_at == 0 && !curly_quote(at_).empty()) curly_at = at_;
      const bool line_ends = ends_line(text_, at_);
      if (line_ends && curly_at > 0) {
        return wrong(curly_at, fmt::format("`{}` does not close a text: the straight `\"` does",
                                           curly_quote(curly_at)));
      }
      if (line_ends) {
        return wrong(begin,
                     "the text that begins here is not closed in its line: a `\"` is "
                     "missing");
      }
      if (text_[at_] == '\\') {
        ++at_;
        if (!escape()) return;
      } else if (text_[at_] != '\0' && static_cast<unsigned char>(text_[at_]) < ' ') {
        const auto code = static_cast<int>(text_[at_]);
        return wrong(at_, code == '\t' ? std::string("a tab in a text is written `\\t`")
                                       : fmt::format("the control character U+{0:04X} in a text is "
                                                     "written `\\u{0:04x}`",
                                                     code));
      }
      ++at_;
    }
    if (at_ >= text_.size()) {
      return wrong(begin, "the text that begins here is not closed: a `\"` is missing");
    }
    last_end_ = ++at_;
    expect_ = next;
  }

  void close() {
    const char c = now();
    const bool fits = (open_.back().bracket == '{') == (c == '}');
    if (!fits) {
      const bool list = open_.back().bracket == '[';
      return wrong(at_, fmt::format("a `{}` is missing before this `{}`: the {} that begins in "
                                    "line {} is not closed",
                                    list ? ']' : '}', c, list ? "list" : "object",
                                    line_of(open_.back().at)));
    }
    open_.pop_back();
    last_is_number_ = last_is_text_ = false;
    last_end_ = ++at_;
    expect_ = after_value();
  }

  // Reads the whole word and returns at most 40 characters of it, as much as a message shows.
  std::string_view take_word() {
    word_at_ = at_;
    while (at_ < text_.size() && is_word(text_[at_])) ++at_;
    return text_.substr(word_at_, std::min<std::size_t>(at_ - word_at_, 40));
  }

  std::string_view text_;
  std::size_t at_ = 0;
  Expect expect_ = Expect::value;
  std::vector<Open> open_;
  std::size_t last_end_ = 0, token_end_ = 0, number_end_ = 0, comma_at_ = 0, word_at_ = 0;
  std::size_t text_at_ = 0;  // where the last text begins
  bool last_is_number_ = false, last_is_text_ = false;
  std::string_view last_word_;  // the last number
  std::optional<JsonMistake> mistake_;
};

}  // namespace

std::optional<JsonMistake> find_json_mistake(std::string_view text) {
  return Walk(text).find();
}

}  // namespace lcrig
