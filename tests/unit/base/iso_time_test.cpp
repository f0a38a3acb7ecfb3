// SPDX-License-Identifier: Apache-2.0
#include "base/iso_time.hpp"

#include <gtest/gtest.h>

namespace lcrig {
namespace {

TEST(IsoTime, HasMillisecondsAndItsOffset) {
  EXPECT_EQ(iso_time(1'767'225'600'250'999'999), "2026-01-01T00:00:00.250+00:00");
  EXPECT_EQ(iso_time(0), "1970-01-01T00:00:00.000+00:00");
  EXPECT_EQ(iso_time(-1), "1969-12-31T23:59:59.999+00:00");
}

}  // namespace
}  // namespace lcrig
