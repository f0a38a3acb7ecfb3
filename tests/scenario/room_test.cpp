// SPDX-License-Identifier: Apache-2.0
// A client asks for a run for which the disk has no room.
#include <gmock/gmock.h>

#include "tests/support/daemon_world.hpp"

namespace lcrig::support {
namespace {

using testing::HasSubstr;

// 137 years at 50 Hz, which is terabytes.
constexpr const char* kEndless = R"({ "format": "load-protocol/1", "name": "endless",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [ { "id": "days", "do": "repeat", "count": 50000, "steps": [
    { "id": "wait", "do": "hold", "hold": "travel", "for_s": 86400 } ] } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";

class NoRoom : public DaemonWorld {};

TEST_F(NoRoom, RefusesTheRunBeforeAnythingMovesAndStillPlansIt) {
  PlainClient client(socket_path());
  const auto refused = answer(client, "run.start", start_request(kEndless));
  ASSERT_TRUE(refused.contains("error")) << refused;
  EXPECT_THAT(refused["error"]["message"].get<std::string>(), HasSubstr("MB are free, but"));
  EXPECT_EQ(count("SELECT count(*) FROM run"), 0);
  const auto planned = answer(client, "run.plan", start_request(kEndless));
  ASSERT_TRUE(planned.contains("result")) << planned;
  EXPECT_GT(planned["result"]["database_bytes"].get<double>(), 1e12);
  const auto added = answer(client, "queue.add", start_request(kEndless));
  ASSERT_TRUE(added.contains("error")) << added;
  EXPECT_THAT(added["error"]["message"].get<std::string>(), HasSubstr("MB are free, but"));
  EXPECT_TRUE(answer(client, "run.start", start_request()).contains("result"));
}

}  // namespace
}  // namespace lcrig::support
