// SPDX-License-Identifier: Apache-2.0
// Runs whose instruments vanish or fall silent, and what must hold afterwards. For scenario tests.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "storage/chain.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {

inline std::string loss_protocol(const std::string& on_loss, const std::string& steps,
                                 const std::string& limit_s = "600") {
  return R"({ "format": "load-protocol/1", "name": "loss", "on_loss": ")" + on_loss +
         R"(", "on_loss_timeout_s": )" + limit_s + R"(,
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast",
      "trigger": "internal" }, "frame": { "rate_Hz": 50 } },
  "steps": [ )" +
         steps + R"( ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";
}

inline constexpr const char* kEveryKind = R"(
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.5 }, "speed_mm_s": 0.01, "timeout_s": 60 },
    { "id": "settle", "do": "hold", "hold": "force", "force_N": 0.5, "for_s": 2 },
    { "id": "level", "do": "measure", "count": 20, "within_s": 4 },
    { "id": "record", "do": "record", "for_s": 2 },
    { "id": "set", "do": "set_lcr", "average": 2 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.5 }, "speed_mm_s": 0.1, "timeout_s": 60 })";

enum class Which { meter, frame };

inline void unplug(SessionWorld& w, Which which) {
  BenchDoor& door = *w.session->instruments().door();
  which == Which::meter ? door.unplug_meter() : door.unplug_frame();
}

inline void plug(SessionWorld& w, Which which) {
  BenchDoor& door = *w.session->instruments().door();
  which == Which::meter ? door.plug_meter() : door.plug_frame();
}

inline void away(SessionWorld& world, const std::string& step, Which which, Duration after,
                 Duration seconds) {
  world.acts.push_back({step, after, [which](SessionWorld& w) { unplug(w, which); }});
  world.acts.push_back({step, after + seconds, [which](SessionWorld& w) { plug(w, which); }});
}

inline std::int64_t events(const SessionWorld& world, const std::string& kind) {
  return world.count("SELECT COUNT(*) FROM event WHERE kind = '" + kind + "'");
}

// Checks what must hold after every run that began, however it ended.
inline void expect_invariants(const SessionWorld& world) {
  EXPECT_EQ(world.clock.pending(), 0U) << "a task still waits";
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM run_end"), 1);
  EXPECT_EQ(world.text("SELECT kind FROM event WHERE kind LIKE 'stop%' ORDER BY seq DESC"),
            "stopped");
  EXPECT_LT(world.real("SELECT MAX(force_N) FROM frame_sample"), 1.02) << "limit 1 N";
  const auto chain = verify_chain(world.open(), 1);
  ASSERT_TRUE(chain) << chain.error().what;
  EXPECT_TRUE(chain->intact) << chain->finding;
}

}  // namespace lcrig
