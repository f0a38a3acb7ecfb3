// SPDX-License-Identifier: Apache-2.0
// Every fault in every phase of a run, in virtual time. In all cases no limit is exceeded, the
// frame stands, no reading is invented or paired with another question, the run is closed with a
// true reason, and nothing is left waiting. docs/faults.md lists the faults.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/fault_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr double kLimit_N = 1.0;
constexpr double kPressing_m_s = 0.05e-3;  // the highest speed of pressing

std::string head(const std::string& trigger, const std::string& rate_Hz) {
  return R"({ "format": "load-protocol/1", "name": "matrix", "on_loss": "wait", "on_loss_timeout_s": 7,
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast",
      "trigger": ")" +
         trigger + R"(" }, "frame": { "rate_Hz": )" + rate_Hz + " } }, ";
}

// The phases are the ids of the steps. "finally" is the only step of `finally`.
const std::string kFrameSteps = R"(
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "near", "do": "ramp", "to": { "travel_mm": 0.57 }, "speed_mm_s": 0.65, "timeout_s": 6 },
    { "id": "approach", "do": "find_contact", "speed_mm_s": 0.05, "force_N": 0.02, "back_off_mm": 0.03, "timeout_s": 6 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.5 }, "speed_mm_s": 0.03, "timeout_s": 6 },
    { "id": "hold", "do": "hold", "hold": "force", "force_N": 0.5, "for_s": 1.5 },
    { "id": "measure", "do": "measure", "count": 6, "within_s": 1.5 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.1 }, "speed_mm_s": 0.1, "timeout_s": 4 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": 0 }, "speed_mm_s": 0.5, "timeout_s": 4 } ] })";

const std::string kRodSteps = R"(
  "steps": [
    { "id": "load", "do": "place_weight", "force_N": 0.5 },
    { "id": "measure", "do": "measure", "count": 6, "within_s": 4 },
    { "id": "hold", "do": "record", "until": "confirmed", "timeout_s": 20 } ],
  "finally_timeout_s": 60,
  "finally": [ { "id": "off", "do": "place_weight", "mass_g": 0 } ] })";

enum class Rig { frame, frame_bus, rod };  // frame_bus: with a triggered meter

enum class Victim { meter, frame, bench };

struct Row {
  const char* name;
  Victim target;
  const char* what;  // members of the fault, except on, in_step and after_s
  bool survived = false;  // the run must succeed in every phase
  // For a lie: the phases in which it is noticed, at once or later. The run must not succeed then.
  const char* comes_out = "";
  // How long and how fast the probe may go on pressing until the lie is noticed.
  double noticed_s = 0, speed_m_s = kPressing_m_s;
};
constexpr const char* kEverywhere = "approach load hold measure unload finally";
void PrintTo(const Row& row, std::ostream* out) {
  *out << row.what;
}

// Some faults begin 0.3 s into the step, because they have a meaning only in the middle of it.
constexpr Row kRows[] = {
    {"reply_late", Victim::meter, R"("fault": "reply_late", "delay_s": 1.5)", true},
    {"reply_lost", Victim::meter, R"("fault": "reply_lost")", true},
    {"reply_cut", Victim::meter, R"("fault": "reply_cut")", true},
    {"reply_doubled", Victim::meter, R"("fault": "reply_doubled")", true},
    {"reply_garbled", Victim::meter, R"("fault": "reply_garbled")", true},
    {"reply_echoed", Victim::meter, R"("fault": "reply_echoed")", true},
    {"replies_late_often", Victim::meter, R"("fault": "reply_late", "delay_s": 1.5, "every": 3)"},
    {"replies_lost_often", Victim::meter, R"("fault": "reply_lost", "probability": 0.3)"},
    {"replies_all_lost", Victim::meter, R"("fault": "reply_lost", "probability": 1)"},
    {"replies_all_garbled", Victim::meter, R"("fault": "reply_garbled", "probability": 1)"},
    {"unsolicited", Victim::meter, R"("fault": "unsolicited")", true},
    {"unsolicited_word", Victim::meter, R"("fault": "unsolicited", "text": "LOW BATTERY")", true},
    {"stuck", Victim::meter, R"("fault": "stuck")"},
    {"overload", Victim::meter, R"("fault": "overload", "for_s": 1)", true},
    {"slow", Victim::meter, R"("fault": "slow", "factor": 8)"},
    {"line_noise", Victim::meter, R"("fault": "line_noise", "byte_probability": 0.01)"},
    {"silent_1s", Victim::meter, R"("fault": "silent", "for_s": 1)", true},
    {"silent", Victim::meter, R"("fault": "silent")"},
    {"unplug_1s", Victim::meter, R"("fault": "unplug", "for_s": 1)", true},
    {"unplug_other_port", Victim::meter, R"("fault": "unplug", "for_s": 1, "other_port": true)",
     true},
    {"unplug", Victim::meter, R"("fault": "unplug")"},
    {"power_cycle", Victim::meter, R"("fault": "power_cycle", "for_s": 1)", true},
    {"power_cycle_set_lost", Victim::meter,
     R"("fault": "power_cycle", "for_s": 1 }, { "fault": "set_lost", "on": "meter", "every": 4)"},
    {"other_instrument", Victim::meter,
     R"("fault": "other_instrument", "identity": "LCR-6100,REV E8.13,OTHER0007,Good Will Instrument Co., Ltd.")"},
    {"other_instrument_1s", Victim::meter,
     R"("fault": "other_instrument", "for_s": 1, "identity": "LCR-6100,REV E8.13,OTHER0007,Good Will Instrument Co., Ltd.")",
     true},

    {"line_late", Victim::frame, R"("fault": "line_late", "delay_s": 0.7)"},
    {"line_lost", Victim::frame, R"("fault": "line_lost")"},
    {"line_cut", Victim::frame, R"("fault": "line_cut")"},
    {"line_doubled", Victim::frame, R"("fault": "line_doubled")", true},
    {"line_garbled", Victim::frame, R"("fault": "line_garbled")"},
    {"lines_lost_often", Victim::frame, R"("fault": "line_lost", "probability": 0.3)"},
    {"lines_cut_often", Victim::frame, R"("fault": "line_cut", "probability": 0.3)"},
    {"line_noise", Victim::frame, R"("fault": "line_noise", "byte_probability": 0.002)"},
    {"samples_lost", Victim::frame, R"("fault": "samples_lost", "samples": 7)", true},
    {"clock_jump", Victim::frame, R"("fault": "clock_jump", "jump_s": -30)", true},
    {"force_spike", Victim::frame, R"("fault": "force_spike", "force_N": 3)"},
    {"force_spike_down", Victim::frame, R"("fault": "force_spike", "force_N": -2)"},
    {"stall", Victim::frame, R"("fault": "stall")", false, "load unload finally"},
    {"overshoot", Victim::frame, R"("fault": "overshoot", "delay_s": 3)"},
    {"refusal", Victim::frame, R"("fault": "refusal")"},
    {"completion_lost", Victim::frame, R"("fault": "completion_lost")"},
    {"heartbeat_lost", Victim::frame, R"("fault": "heartbeat_lost", "for_s": 3)"},
    {"gateway_restarted", Victim::frame, R"("fault": "gateway_restarted")", true},
    {"gateway_restarted_zero", Victim::frame,
     R"("fault": "gateway_restarted", "forgets_zero": true)"},
    {"silent_1s", Victim::frame, R"("fault": "silent", "for_s": 1)"},
    {"silent", Victim::frame, R"("fault": "silent")"},
    {"deaf_1s", Victim::frame, R"("fault": "deaf", "for_s": 1)"},
    {"deaf", Victim::frame, R"("fault": "deaf")"},
    {"unplug_1s", Victim::frame, R"("fault": "unplug", "for_s": 1)", true},
    {"unplug_other_port", Victim::frame, R"("fault": "unplug", "for_s": 1, "other_port": true)",
     true},
    {"unplug", Victim::frame, R"("fault": "unplug")"},
    {"power_cycle", Victim::frame, R"("fault": "power_cycle", "for_s": 1)"},

    {"force_frozen", Victim::frame, R"("fault": "force_frozen")", false, kEverywhere, 1.0},
    {"force_reversed", Victim::frame, R"("fault": "force_reversed")", false,
     "approach load hold measure", 0.3},
    {"force_drift", Victim::frame, R"("fault": "force_drift", "rate_N_s": 0.002)", false, "", 2},
    {"force_drift_down", Victim::frame, R"("fault": "force_drift", "rate_N_s": -0.002)", false, "",
     2},
    {"force_scatter", Victim::frame, R"("fault": "force_scatter", "factor": 20)", false, "", 0.3},
    {"drive_reversed", Victim::frame, R"("fault": "drive_reversed")", false, kEverywhere, 0.3,
     0.5e-3},
    {"creep", Victim::frame, R"("fault": "creep", "speed_um_s": 20)", false, "approach", 0.3},
    {"creep_away", Victim::frame, R"("fault": "creep", "speed_um_s": -20)", false, "approach", 0.3},
    {"done_early", Victim::frame, R"("fault": "done_early")", false, kEverywhere, 0.7},
    {"done_unmoved", Victim::frame, R"("fault": "done_unmoved")", false,
     "approach load hold measure unload", 0.7},
    {"done_late_1s", Victim::frame, R"("fault": "done_late", "delay_s": 1)"},
    {"done_late", Victim::frame, R"("fault": "done_late", "delay_s": 5)", false, kEverywhere},
    {"order_late_1s", Victim::frame, R"("fault": "order_late", "delay_s": 1)", false, "", 0.3},
    {"order_late", Victim::frame, R"("fault": "order_late", "delay_s": 5)", false,
     "approach load hold measure", 0.3},
    {"clock_frozen", Victim::frame, R"("fault": "clock_frozen")", true},
    {"clock_rate", Victim::frame, R"("fault": "clock_rate", "factor": 2)", true},
    {"clock_slow", Victim::frame, R"("fault": "clock_rate", "factor": 0.985)", true},
    {"clock_set", Victim::frame, R"("fault": "clock_jump", "jump_s": 0.3)", true},
    {"tare_lost", Victim::frame, R"("fault": "tare_lost")", false, "", 0.3},
    {"tare_lost_told", Victim::frame, R"("fault": "tare_lost", "origin_changes": true)", false,
     kEverywhere, 0.3},
    {"estop", Victim::frame, R"("fault": "estop")", false, kEverywhere},
    {"estop_1s", Victim::frame, R"("fault": "estop", "for_s": 1)", false, kEverywhere},
    {"stop_late_500ms", Victim::frame, R"("fault": "stop_late", "delay_s": 0.5)", true},
    {"stop_late", Victim::frame, R"("fault": "stop_late", "delay_s": 5)"},
    {"stop_unconfirmed", Victim::frame, R"("fault": "stop_unconfirmed")", false, kEverywhere},
    {"stop_ignored", Victim::frame, R"("fault": "stop_ignored")", false, kEverywhere},
    {"stop_pretended", Victim::frame, R"("fault": "stop_pretended")"},
    {"stop_silences", Victim::frame, R"("fault": "stop_silences")", false, kEverywhere},
    {"caps_changed", Victim::frame, R"("fault": "caps_changed")", false, kEverywhere},

    {"operator_absent", Victim::bench, R"("fault": "operator_absent", "for_s": 8)", true},
    {"operator_never", Victim::bench, R"("fault": "operator_absent", "for_s": 3600)"},
    {"disk_full", Victim::bench, R"("fault": "disk_full")"},
    {"disk_full_1s", Victim::bench, R"("fault": "disk_full", "for_s": 1)"},
    {"disk_read_only", Victim::bench, R"("fault": "disk_read_only")"},
    {"disk_read_only_1s", Victim::bench, R"("fault": "disk_read_only", "for_s": 1)"},
    {"disk_slow", Victim::bench, R"("fault": "disk_slow", "delay_s": 0.002)", true},
    {"wall_clock_step", Victim::bench, R"("fault": "wall_clock_step", "step_s": -3600)", true},
    {"memory_short", Victim::bench, R"("fault": "memory_short")"},
    {"memory_short_1s", Victim::bench, R"("fault": "memory_short", "for_s": 1)"},
};

const char* to_string(Victim t) {
  switch (t) {
    case Victim::meter: return "meter";
    case Victim::frame: return "frame";
    case Victim::bench: return "bench";
  }
  return "?";
}

struct Cell {
  const Row* row;
  const char* phase;
  Rig rig;
};

bool is(const Row& row, std::string_view name) {
  return row.name == name;
}

// Some faults cannot happen in some phases: nothing is commanded while a level is measured, no
// motion ends while a force is held, and nobody is asked anything on a frame.
bool has_occasion(const Row& row, std::string_view phase, Rig rig) {
  const bool moves =
      phase == "approach" || phase == "load" || phase == "unload" || phase == "finally";
  if (is(row, "refusal")) return moves || phase == "hold";
  if (is(row, "completion_lost") || is(row, "stall")) return moves;
  if (is(row, "operator_absent") || is(row, "operator_never")) {
    return rig == Rig::rod && phase != "measure";
  }
  return true;
}

std::vector<Cell> cells_of(const Row& row) {
  const std::vector<const char*> frame{"approach", "load", "hold", "measure", "unload", "finally"};
  // phases in which a trigger matters to the meter
  const std::vector<const char*> triggered{"load", "measure"};
  const std::vector<const char*> rod{"load", "measure", "hold", "finally"};
  std::vector<Cell> out;
  for (const Rig rig : {Rig::frame, Rig::frame_bus, Rig::rod}) {
    if (rig == Rig::frame_bus && row.target != Victim::meter) continue;
    if (rig == Rig::rod && row.target == Victim::frame) continue;
    for (const char* phase : rig == Rig::rod ? rod : rig == Rig::frame ? frame : triggered) {
      if (has_occasion(row, phase, rig)) out.push_back({&row, phase, rig});
    }
  }
  return out;
}

std::string name_of(const Cell& c) {
  const char* rig = c.rig == Rig::rod ? "_rod" : c.rig == Rig::frame_bus ? "_triggered" : "";
  return fmt::format("{}_{}_{}{}", to_string(c.row->target), c.row->name, c.phase, rig);
}

std::string script_of(const Cell& c) {
  const bool from_the_start = is(*c.row, "refusal") || is(*c.row, "overshoot");
  return fmt::format(
      R"({{ "format": "faults/1", "seed": 5, "faults": [ {{ "on": "{}", "in_step": "{}", "after_s": {}, {} }} ] }})",
      to_string(c.row->target), c.phase, from_the_start ? 0 : 0.3, c.row->what);
}

// Words of which the true reason for the end of a run contains at least one.
std::vector<std::string_view> culprits(Victim t) {
  switch (t) {
    case Victim::meter: return {"lcr", "meter", "readings"};
    case Victim::frame: return {"frame", "gateway", "force", "motion", "travel", "cell", "E-stop"};
    case Victim::bench: return {"t.db", "a person", "`finally` did not end"};
  }
  return {};
}

bool names_one_of(const std::string& reason, const std::vector<std::string_view>& words) {
  return std::ranges::any_of(words,
                             [&](std::string_view w) { return reason.find(w) != reason.npos; });
}

void play(const Cell& cell, std::map<std::string, int>& ended) {
  const bool rod = cell.rig == Rig::rod;
  const std::string trigger = cell.rig == Rig::frame_bus ? "bus" : "internal";
  FaultWorld world(head(trigger, rod ? "10" : "50") + (rod ? kRodSteps : kFrameSteps),
                   script_of(cell));
  world.bench.plant.contact_travel_m = 0.6e-3;
  if (is(*cell.row, "operator_never")) {
    const char* step = std::string_view(cell.phase) == "finally" ? "off" : cell.phase;
    world.acts.push_back(
        {step, 40s, [](SessionWorld& w) { w.interrupt(Interrupt::abort, "a person"); }});
  }
  const auto result = world.run();
  FaultLimits limits;
  limits.force_max_N = kLimit_N;
  limits.speed_m_s = rod ? 0 : kPressing_m_s;
  if (cell.row->noticed_s > 0) {
    limits.reaction_s = cell.row->noticed_s;
    limits.speed_m_s = cell.row->speed_m_s;
  }
  limits.may_move_on = is(*cell.row, "stop_ignored") || is(*cell.row, "order_late") ||
                       is(*cell.row, "stop_pretended") || is(*cell.row, "stop_silences");
  // The guard stops a device that stops too late, after one batch of 100 ms and the transmission.
  if (is(*cell.row, "overshoot")) limits.reaction_s = 0.12;
  Invariants invariants(world, result, limits);
  ASSERT_NO_FATAL_FAILURE(invariants.expect_all());
  EXPECT_GT(world.player->happened().front(), 0) << "the fault never happened";
  if (result->exit_status != ExitStatus::success) {
    EXPECT_TRUE(names_one_of(result->reason, culprits(cell.row->target))) << result->reason;
  }
  if (cell.row->survived) {
    EXPECT_EQ(result->exit_status, ExitStatus::success) << result->reason;
  }
  const bool comes_out =
      std::string_view(cell.row->comes_out).find(cell.phase) != std::string_view::npos;
  if (comes_out) {
    EXPECT_NE(result->exit_status, ExitStatus::success) << "nobody noticed";
  }
  // Either `finally` clears the specimen, or the reason says why it did not.
  const bool says_why = names_one_of(result->reason, {"`finally`", "is still loaded"});
  if (!rod && !says_why && !limits.may_move_on) {
    EXPECT_NEAR(world.last_travel_m, 0, 1e-5) << result->reason;
    EXPECT_EQ(world.last_force_N, 0);
  }
  if (is(*cell.row, "wall_clock_step")) {
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind = 'clock_step'"), 1);
  }
  if (is(*cell.row, "heartbeat_lost") && std::string_view(cell.phase) == "hold") {
    EXPECT_GE(world.count("SELECT COUNT(*) FROM event WHERE kind = 'loss'"), 1)
        << "the gateway stopped by itself";
  }
  ++ended[std::string(to_string(result->exit_status))];
}

// One test per row. The trace of a failure names the cell.
class FaultMatrix : public ::testing::TestWithParam<Row> {};

TEST_P(FaultMatrix, KeepsThePromisesInEveryPhase) {
  std::map<std::string, int> ended;
  for (const Cell& cell : cells_of(GetParam())) {
    SCOPED_TRACE(name_of(cell));
    play(cell, ended);
  }
  std::string words;
  for (const auto& [how, n] : ended) words += fmt::format(" {} {}", n, how);
  std::printf("%s %s:%s\n", to_string(GetParam().target), GetParam().name, words.c_str());
}

INSTANTIATE_TEST_SUITE_P(EveryFault, FaultMatrix, ::testing::ValuesIn(kRows), [](const auto& r) {
  return fmt::format("{}_{}", to_string(r.param.target), r.param.name);
});

// docs/promises.md states this number.
TEST(FaultMatrixItself, HasSoManyCells) {
  std::size_t cells = 0;
  for (const Row& row : kRows) cells += cells_of(row).size();
  EXPECT_EQ(cells, 717U);
}

// The matrix proves nothing unless the runs get as far as every phase.
TEST(FaultMatrixItself, WithoutFaultsTheRunsSucceedAndMeasure) {
  for (const Rig rig : {Rig::frame, Rig::frame_bus, Rig::rod}) {
    const bool rod = rig == Rig::rod;
    FaultWorld world(head(rig == Rig::frame_bus ? "bus" : "internal", rod ? "10" : "50") +
                         (rod ? kRodSteps : kFrameSteps),
                     "");
    world.bench.plant.contact_travel_m = 0.6e-3;
    const auto result = world.run();
    FaultLimits limits;
    limits.speed_m_s = rod ? 0 : kPressing_m_s;
    Invariants(world, result, limits).expect_all();
    EXPECT_EQ(result->exit_status, ExitStatus::success) << result->reason;
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM lcr_reading WHERE level = 1"), 6);
    EXPECT_GT(world.peak_N, 0.45);
  }
}

}  // namespace
}  // namespace lcrig
