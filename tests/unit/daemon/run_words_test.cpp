// SPDX-License-Identifier: Apache-2.0
#include "daemon/run_words.hpp"

#include <gtest/gtest.h>

namespace lcrig {
namespace {

TEST(RunWords, TheServiceSaysOnlyWhatIsKnown) {
  RunStatus s;
  s.run = 3;
  s.protocol = "creep";
  s.specimen = "paper-1";
  EXPECT_EQ(service_line(s), "run 3 creep on paper-1: preparing");
  s.simulated = true;
  s.state = RunState::waiting_for_operator;
  s.step_id = "load";
  s.elapsed_s = 30;
  s.left_s = 90;
  s.prompt = "place 50 g";
  EXPECT_EQ(service_line(s),
            "simulated run 3 creep on paper-1: waiting_for_operator, load, 25 %, 2 min left; waits "
            "for: place 50 g");
  s.prompt = "";
  s.elapsed_s = 999;
  s.left_s = 1;
  EXPECT_EQ(service_line(s),
            "simulated run 3 creep on paper-1: waiting_for_operator, load, 99 %, 1 min left");
}

TEST(RunWords, AnEndSaysWhyAndItsAnchor) {
  RunOutcome ended;
  ended.run = 3;
  ended.exit_status = ExitStatus::success;
  EXPECT_EQ(ended_line(ended), "run 3 ended: success");
  ended.exit_status = ExitStatus::abort;
  ended.reason = "SIGTERM";
  ended.simulated = true;
  ended.anchor = "57:9c4f";
  EXPECT_EQ(ended_line(ended), "simulated run 3 ended: abort SIGTERM (anchor 57:9c4f)");
}

TEST(RunWords, ARunWithoutAnEndIsSaidToHaveEndedIfItHad) {
  EXPECT_EQ(orphan_line(3, "57:9c4f", false),
            "run 3 had not ended when the last daemon died: closed as interrupted (anchor "
            "57:9c4f); look whether its specimen is still loaded (lcrig runs show 3)");
  EXPECT_EQ(orphan_line(3, "57:9c4f", true),
            "run 3 had ended, and its end was deleted from the database: its chain is cut. It is "
            "closed as interrupted, and the anchor of its end is kept (57:9c4f). `lcrig verify 3` "
            "tells what is missing");
}

}  // namespace
}  // namespace lcrig
