// SPDX-License-Identifier: Apache-2.0
#include "plot/text.hpp"

#include <gmock/gmock.h>

namespace lcrig::plot {
namespace {

using testing::ElementsAre;

TEST(Escape, MarkupAndQuotesAreText) {
  EXPECT_EQ(escape("<b a=\"1\" c='2'>&"), "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;");
}

TEST(Escape, ControlCharactersBecomePictures) {
  EXPECT_EQ(escape("a\x1b[0m\r\x7f"), "a␛[0m␍␡");
  EXPECT_EQ(escape(std::string_view("\0", 1)), "␀");
  EXPECT_EQ(escape("a\n\tb"), "a\n\tb");
}

TEST(Escape, TextIsNotReordered) {
  EXPECT_EQ(escape("a\u202Eb\u2066c"), "a\uFFFDb\uFFFDc");
}

TEST(Escape, WhatIsNoUtf8IsReplaced) {
  EXPECT_EQ(escape("\xff\xfe"), "\uFFFD\uFFFD");
  EXPECT_EQ(escape("\xc3"), "\uFFFD");  // cut off
  EXPECT_EQ(escape("\xc0\xbc"), "\uFFFD\uFFFD");  // an overlong <
  EXPECT_EQ(escape("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");  // a surrogate
  EXPECT_EQ(escape("µΔ∆😀"), "µΔ∆😀");
}

TEST(TextWidth, GrowsWithTheTextAndTheSize) {
  EXPECT_LT(text_width("ill", 12), text_width("MWM", 12));
  EXPECT_DOUBLE_EQ(text_width("abc", 24), 2 * text_width("abc", 12));
}

TEST(CutToWidth, EndsWithAnEllipsis) {
  EXPECT_EQ(cut_to_width("short", 100, 12), "short");
  const std::string cut = cut_to_width("a very long name of a specimen", 60, 12);
  EXPECT_TRUE(cut.ends_with("…"));
  EXPECT_LE(text_width(cut, 12), 60);
}

TEST(Wrap, BreaksAtBlanks) {
  EXPECT_THAT(wrap("aaaa bbbb cccc", text_width("aaaa bbbb", 12), 12),
              ElementsAre("aaaa bbbb", "cccc"));
  EXPECT_TRUE(wrap("", 100, 12).empty());
}

}  // namespace
}  // namespace lcrig::plot
