// SPDX-License-Identifier: Apache-2.0
#include "analysis/csv.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/hostile_texts.hpp"

namespace lcrig {
namespace {

std::string cell(std::string_view text) {
  std::string out;
  append_text_cell(out, text);
  return out;
}

TEST(TextCell, IsQuotedAsRfc4180HasIt) {
  EXPECT_EQ(cell("plain text"), "plain text");
  EXPECT_EQ(cell("a,b"), "\"a,b\"");
  EXPECT_EQ(cell("say \"no\""), "\"say \"\"no\"\"\"");
  EXPECT_EQ(cell("two\r\nlines"), "\"two\r\nlines\"");
  EXPECT_EQ(cell("OUT ,AUX-NG,NG"), "\"OUT ,AUX-NG,NG\"");
  EXPECT_EQ(cell(""), "");
}

// The single cell of a line as a reader of RFC 4180 sees it. Fails if it is not a single cell.
std::string read_back(const std::string& written) {
  if (!written.starts_with('"')) {
    EXPECT_EQ(written.find_first_of(",\"\r\n"), std::string::npos) << written.substr(0, 80);
    return written;
  }
  std::string out;
  std::size_t i = 1;
  for (; i < written.size(); ++i) {
    if (written[i] == '"' && (++i == written.size() || written[i] != '"')) break;
    out += written[i];
  }
  EXPECT_EQ(i, written.size()) << "something follows the closing quote";
  return out;
}

TEST(TextCell, HoldsEveryHostileTextAndNoFormula) {
  for (const auto& [name, text] : support::hostile_texts()) {
    const std::string got = read_back(cell(text));
    std::string without = got;
    std::erase(without, '\r');
    EXPECT_EQ(without, printable_lines(without)) << name;
    EXPECT_EQ(std::string("=+-@\t\r\n").find(got.front()), std::string::npos) << name;
    EXPECT_GE(got.size(), text.size()) << name << ": nothing is lost";
  }
}

TEST(TextCell, ShowsControlCharacters) {
  EXPECT_EQ(cell("a\x1b[31m"), "a\\x1b[31m");
  EXPECT_EQ(cell("\u202E"), "\\u202e");
  EXPECT_EQ(cell("\xff"), "\\xff");
  EXPECT_EQ(cell("a\tb"), "\"a\tb\"");
}

TEST(TextCell, IsNeverAFormula) {
  EXPECT_EQ(cell("=1+1"), "'=1+1");
  EXPECT_EQ(cell("@SUM(A1)"), "'@SUM(A1)");
  EXPECT_EQ(cell("-2"), "'-2");
  EXPECT_EQ(cell("+2"), "'+2");
  EXPECT_EQ(cell("=HYPERLINK(\"a\",\"b\")"), "\"'=HYPERLINK(\"\"a\"\",\"\"b\"\")\"");
  EXPECT_EQ(cell("a=b"), "a=b");
  EXPECT_EQ(cell("  =1+1"), "'  =1+1");
  EXPECT_EQ(cell("\n=1+1"), "\"'\n=1+1\"");
  EXPECT_EQ(cell("\uFF1D1"), "'\uFF1D1");
}

}  // namespace
}  // namespace lcrig
