// SPDX-License-Identifier: Apache-2.0
// Checks that a text is well-formed XML, as far as SVG and our HTML need it. Finds missing escapes
// in charts and reports.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace lcrig {

class XmlCheck {
 public:
  // Empty when well-formed, otherwise what is wrong and where. `void_elements` have no end tag
  // ("br").
  static std::string fault(std::string_view text, std::vector<std::string> void_elements = {}) {
    XmlCheck check(text, std::move(void_elements));
    return check.run();
  }

 private:
  XmlCheck(std::string_view text, std::vector<std::string> void_elements)
      : text_(text), void_(std::move(void_elements)) {}

  std::string run() {
    if (text_.starts_with("<!DOCTYPE html>")) at_ = 15;
    while (fault_.empty() && at_ < text_.size()) {
      if (text_[at_] != '<') {
        content();
      } else if (text_.substr(at_).starts_with("</")) {
        end_tag();
      } else {
        start_tag();
      }
    }
    if (fault_.empty() && !open_.empty()) fail("<" + open_.back() + "> is not closed");
    return fault_;
  }

  void fail(const std::string& why) {
    if (fault_.empty()) {
      fault_ = why + " at byte " + std::to_string(at_) + ": " + std::string(text_.substr(at_, 60));
    }
  }

  void reference() {
    const auto end = text_.find(';', at_);
    if (end == text_.npos || end - at_ > 8) return fail("a bare &");
    at_ = end + 1;
  }

  void content() {
    const char c = text_[at_];
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&') return reference();
    if (byte < 0x20 && c != '\n' && c != '\t') return fail("a control character");
    ++at_;
  }

  std::string name() {
    const auto begin = at_;
    const auto good = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == ':';
    };
    while (at_ < text_.size() && good(text_[at_])) ++at_;
    if (at_ == begin) fail("a name is missing");
    return std::string(text_.substr(begin, at_ - begin));
  }

  void blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }

  void end_tag() {
    at_ += 2;
    const std::string word = name();
    if (open_.empty() || open_.back() != word) return fail("</" + word + "> closes nothing");
    open_.pop_back();
    if (at_ >= text_.size() || text_[at_] != '>') return fail("> is missing");
    ++at_;
  }

  void attribute() {
    name();
    if (at_ + 1 >= text_.size() || text_[at_] != '=') return fail("= is missing");
    const char quote = text_[++at_];
    if (quote != '\'' && quote != '"') return fail("a value without quotes");
    for (++at_; fault_.empty() && at_ < text_.size() && text_[at_] != quote;) {
      if (text_[at_] == '<') return fail("< in a value");
      content();
    }
    ++at_;
  }

  void start_tag() {
    ++at_;
    const std::string word = name();
    bool closed = std::ranges::count(void_, word) > 0;
    for (blanks(); fault_.empty() && at_ < text_.size(); blanks()) {
      if (text_[at_] == '>') break;
      if (text_[at_] == '/') {
        closed = true;
        ++at_;
        continue;
      }
      attribute();
    }
    if (at_ >= text_.size()) return fail("a tag does not end");
    ++at_;
    if (word == "style" || word == "script") at_ = std::min(text_.find("</", at_), text_.size());
    if (!closed) open_.push_back(word);
  }

  std::string_view text_;
  std::vector<std::string> void_, open_;
  std::size_t at_ = 0;
  std::string fault_;
};

}  // namespace lcrig
