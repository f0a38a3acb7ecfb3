// SPDX-License-Identifier: Apache-2.0
#include "events/event_words.hpp"

#include <gtest/gtest.h>

#include "events/payloads.hpp"

namespace lcrig {
namespace {

TEST(EventWords, FieldsHaveTheirUnitsAndLengthsAreInMillimetres) {
  ContactEvent contact;
  contact.travel_m = 0.0032005;
  contact.force_N = 0.0234;
  EXPECT_EQ(event_words(to_json(contact)), "force 0.0234 N, travel 3.2005 mm");
  ReconnectedEvent back;
  back.instrument = "frame";
  back.seconds = 2.5;
  back.away_s = 2.4;
  back.attempts = 3;
  EXPECT_EQ(event_words(to_json(back)), "attempts 3, away 2.4 s, instrument frame, seconds 2.5");
}

TEST(EventWords, WordsStayAsTheyAre) {
  EXPECT_EQ(event_words("by root"), "by root");
  EXPECT_EQ(event_words(""), "");
  EXPECT_EQ(event_words("[1, 2]"), "[1, 2]");
  EXPECT_EQ(event_words("{broken"), "{broken");
}

}  // namespace
}  // namespace lcrig
