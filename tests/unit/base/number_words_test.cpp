// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/number.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

TEST(NumberWords, SayWhyATextIsNoNumber) {
  EXPECT_THAT(number_words("\u22125"), HasSubstr("is no minus sign"));
  EXPECT_THAT(number_words("+5"), HasSubstr("no `+`"));
  EXPECT_THAT(number_words("1e999"), HasSubstr("larger or smaller"));
  EXPECT_THAT(number_words("12,5"), HasSubstr("12.5"));
  EXPECT_THAT(number_words("125 um", "um"), HasSubstr("leave it out"));
  EXPECT_THAT(number_words("125um", "um"), HasSubstr("leave it out"));
}

TEST(NumberWords, AreSilentWhereTheReasonIsNotKnown) {
  for (const char* text : {"", "many", "+", "um", "1 2", "0x10"}) {
    EXPECT_EQ(number_words(text, "um"), "") << text;
  }
  EXPECT_EQ(number_words("125 mm", "um"), "");
  EXPECT_EQ(number_words("125 um"), "");
}

}  // namespace
}  // namespace lcrig
