// SPDX-License-Identifier: Apache-2.0
// Properties that must hold on a frame that lies, behind an honest gateway or a lying one.
// docs/testing.md says which lies can be noticed, and when.
#include <gtest/gtest.h>

#include "tests/property/lie_judge.hpp"
#include "tests/property/sweep.hpp"

namespace lcrig::property {
namespace {

FrameLie any_lie(Dice& dice) {
  return static_cast<FrameLie>(dice.below(kFrameLies));
}
bool is_of_stop(FrameLie lie) {
  using enum FrameLie;
  return lie == stop_late || lie == stop_unconfirmed || lie == stop_ignored;
}

// A lie about STOP shows only if there is a STOP.
void abort_it(Dice& dice, Case& c) {
  Happening h;
  h.kind = Happening::Kind::abort;
  h.when = RigWorld::Act::When::drive;
  h.n = dice.below(8);
  h.after_s = dice.even(0, 2);
  c.happenings.push_back(h);
}

void tell_lies(std::uint64_t draw, Case& c, int lies) {
  Dice dice(draw);
  const sim::RandomRig rig = c.make_rig();
  for (int i = 0; i < lies; ++i) {
    const FrameLie lie = any_lie(dice);
    c.lies.push_back(draw_falsehood(dice, lie, rig));
    if (is_of_stop(lie) && dice.below(10) < 7 && c.happenings.empty()) abort_it(dice, c);
  }
}

void play(const std::string& name, double share, int lies,
          const std::vector<std::string>& sometimes) {
  Kind kind{name, share, false, 0, {}};
  kind.disturb = [lies](std::uint64_t draw, Case& c) { tell_lies(draw, c, lies); };
  LieTable table;
  kind.note = [&table](Trial& t) { table.add(t.lie_figures); };
  sweep(kind, lies_come_out, sometimes);
  table.write(name + "-table");
}

TEST(Properties, ALieOfTheFrameIsNoticedInTime) {
  play("frame-lies", 5, 1,
       {"force_frozen: contradicted",
        "force_held: told",  // rarely where it can be noticed; LyingRig.EachLie* tests that
        "force_gain: contradicted",
        "force_reversed: contradicted",
        "stall: contradicted",
        "drive_reversed: contradicted",
        "creep: contradicted",
        "estop: contradicted",
        "done_early: contradicted",
        "done_unmoved: contradicted",
        "done_late: contradicted",
        "order_late: contradicted",
        "stop_unconfirmed: contradicted",
        "stop_ignored: contradicted",
        "force_drift: told",
        "force_scatter: told",
        "tare_lost: told",
        "clock_rate: told",
        "clock_jump: told",
        "samples_late: told",
        "restart_untared: told",
        "caps_changed: told",
        "stop_late: told"});
}

TEST(Properties, TwoLiesOfTheFrameAtATimeAreNoticedInTime) {
  play("frame-lies-2", 3, 2, {"force_frozen: contradicted", "creep: contradicted"});
}

}  // namespace
}  // namespace lcrig::property
