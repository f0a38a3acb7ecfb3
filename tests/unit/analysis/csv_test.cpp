// SPDX-License-Identifier: Apache-2.0
#include "analysis/csv.hpp"

#include <gtest/gtest.h>

#include <string>

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

TEST(TextCell, IsNeverAFormula) {
  EXPECT_EQ(cell("=1+1"), "'=1+1");
  EXPECT_EQ(cell("@SUM(A1)"), "'@SUM(A1)");
  EXPECT_EQ(cell("-2"), "'-2");
  EXPECT_EQ(cell("+2"), "'+2");
  EXPECT_EQ(cell("=HYPERLINK(\"a\",\"b\")"), "\"'=HYPERLINK(\"\"a\"\",\"\"b\"\")\"");
  EXPECT_EQ(cell("a=b"), "a=b");
}

}  // namespace
}  // namespace lcrig
