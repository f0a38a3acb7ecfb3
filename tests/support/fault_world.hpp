// SPDX-License-Identifier: Apache-2.0
// A whole run in virtual time on a bench with faults, and a record of the truth: every reading and
// sample that the instruments gave, and the true force and travel. For scenario tests.
#pragma once

#include <gtest/gtest.h>

#include <charconv>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "daemon/record/database.hpp"
#include "daemon/rig/drill.hpp"
#include "drivers/faults/player.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"
#include "model/plant.hpp"
#include "storage/chain.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {

class FaultWorld : public SessionWorld {
 public:
  // `script`: the text of a fault script; empty: no faults.
  FaultWorld(std::string protocol, std::string script)
      : SessionWorld(std::move(protocol)), script_(std::move(script)) {}
  ~FaultWorld() override { player.reset(); }

  struct Given {  // a reading that the meter sent
    MonoTime t;
    std::string text;
  };
  std::vector<Given> given;
  std::multimap<std::int64_t, FrameSample> samples;  // by the device's sequence number
  double peak_N = 0;  // true force on the specimen, largest so far
  double top_m = -1, bottom_m = 1;  // extremes of the true travel
  bool stood = false;  // the frame stood still when the run row was closed
  MonoTime over;

  std::function<void(SimRequest&)> adjust_sim;
  VirtualSurroundings surroundings{clock};
  std::unique_ptr<FaultPlayer> player;
  const Plant* plant = nullptr;
  // Values at the end of the run, before the ports were closed.
  double last_force_N = 0, last_travel_m = 0;

 protected:
  void adjust(SimRequest& sim, Recorder::Options& recorder) override {
    recorder.vfs = surroundings.disk().name();
    if (adjust_sim) adjust_sim(sim);
  }

  void built() override {
    BenchDoor& door = *session->instruments().door();
    plant = door.plant();
    door.meter_sim().watch(
        [this](MonoTime t, const std::string& text) { given.push_back({t, text}); });
    if (door.frame_sim() != nullptr) {
      door.frame_sim()->watch = [this](MonoTime, const FrameSample& s) {
        samples.emplace(s.device_seq, s);
        look();
      };
    }
    asio::co_spawn(io, witness(), [](std::exception_ptr e) {
      if (e) std::rethrow_exception(e);
    });
    if (script_.empty()) return;
    auto script = parse_fault_script(script_, "script");
    if (!script) throw std::runtime_error(script.error().what);
    player = std::make_unique<FaultPlayer>(io.get_executor(), clock, door, &surroundings,
                                           std::move(*script), [](MonoTime, const std::string&) {});
    Session::Listener listener;
    listener.step = [this](const RunProgress& s) {
      player->enter_step(s.step_id, s.step_kind, s.state == RunState::finishing);
    };
    session->set_listener(std::move(listener));
  }
  void began() override {
    if (player) player->begin();
  }
  void ended() override {
    look();
    over = clock.now();
    const auto arrival = plant->arrival();
    stood = !arrival || *arrival <= over;
    last_force_N = plant->force_N(over);
    last_travel_m = plant->travel_m(over);
    witnessed_ = true;
    if (player) player->stop();
  }

 private:
  void look() {
    const MonoTime now = clock.now();
    peak_N = std::max(peak_N, plant->force_N(now));
    const double travel_m = plant->travel_m(now);
    top_m = std::max(top_m, travel_m);
    bottom_m = std::min(bottom_m, travel_m);
  }
  Task<> witness() {
    while (!witnessed_) {
      look();
      co_await clock.wait_for(std::chrono::milliseconds(50));
    }
  }

  std::string script_;
  bool witnessed_ = false;
};

// Bounds that must hold whatever went wrong.
struct FaultLimits {
  FaultLimits() = default;
  double force_max_N = 1, travel_min_m = -10e-3, travel_max_m = 10e-3;
  double speed_m_s = 0;  // highest speed of pressing
  // added to the device's own reaction, for a device that does not stop by itself
  double reaction_s = 0;
  bool may_move_on = false;  // the frame ignores STOP
};

class Invariants {
 public:
  Invariants(FaultWorld& world, const Result<RunResult>& result, FaultLimits limits)
      : world_(world), result_(result), limits_(limits) {}

  void expect_all() {
    ASSERT_TRUE(result_) << result_.error().what;
    expect_nothing_waits();
    expect_closed_run();
    expect_safe_frame();
    expect_true_readings();
    expect_true_samples();
  }

 private:
  void expect_nothing_waits() {
    EXPECT_EQ(world_.clock.pending(), 0U) << "a task still waits";
    world_.io.restart();
    world_.io.poll();
    EXPECT_TRUE(world_.io.stopped()) << "something is left in the loop";
    EXPECT_TRUE(!world_.player || world_.player->is_idle());
  }

  // If the disk accepts nothing more, the run stays open and the next start closes it.
  void expect_closed_run() {
    if (world_.count("SELECT COUNT(*) FROM run_end") == 0) {
      EXPECT_EQ(result_->exit_status, ExitStatus::fail) << "an end that nobody stored";
      EXPECT_NE(result_->reason.find(world_.database()), std::string::npos) << result_->reason;
      const auto owned = open_as_owner(world_.database(), 1);
      ASSERT_TRUE(owned) << owned.error().what;
      EXPECT_EQ(owned->interrupted.size(), 1U);
    }
    ASSERT_EQ(world_.count("SELECT COUNT(*) FROM run_end"), 1);
    const std::string status = world_.text("SELECT exit_status FROM run_end");
    const std::string reason = world_.text("SELECT reason FROM run_end");
    if (status != "interrupted") {
      EXPECT_EQ(status, to_string(result_->exit_status));
    }
    EXPECT_EQ(reason.empty(), status == "success") << reason;
    const auto chain = verify_chain(world_.open(), 1);
    ASSERT_TRUE(chain) << chain.error().what;
    EXPECT_TRUE(chain->intact) << chain->finding;
  }

  void expect_safe_frame() {
    const Plant& plant = *world_.plant;
    const PlantConfig& p = plant.config();
    const double v = limits_.speed_m_s;
    const double way_m = v * (limits_.reaction_s + p.drive_lag_s) + v * v / 2 / p.deceleration_m_s2;
    const double at_limit_m = plant.travel_at_force_m(limits_.force_max_N);
    // The tare is only as good as the noise of the cell.
    const double bound_N = plant.force_at_travel_N(at_limit_m + way_m) + 4 * p.force_noise_N;
    EXPECT_LE(world_.peak_N, bound_N) << "limit " << limits_.force_max_N << " N";
    EXPECT_LE(world_.top_m, limits_.travel_max_m);
    EXPECT_GE(world_.bottom_m, limits_.travel_min_m);
    if (!limits_.may_move_on) {
      EXPECT_TRUE(world_.stood) << "the run was closed while the frame moved";
    }
  }

  static double number(const std::string& text, std::size_t from) {
    if (text[from] == '+') ++from;
    double value = 0;
    std::from_chars(text.data() + from, text.data() + text.size(), value);
    return value;
  }

  // Each stored reading must be one that the meter gave between this question and this answer.
  void expect_true_readings() {
    const Database db = world_.open();
    auto row = db.prepare(
                     "SELECT asked_mono_ns, first_byte_mono_ns, capacitance_F, dissipation, "
                     "flags FROM lcr_reading ORDER BY seq")
                   .value();
    std::int64_t wrong = 0;
    while (row.step().value()) {
      const MonoTime asked{Duration(row.integer(0))}, answered{Duration(row.integer(1))};
      bool found = false;
      for (const auto& g : world_.given) {
        if (g.t < asked || g.t > answered) continue;
        found = found || is_same(g.text, row);
      }
      if (!found && ++wrong <= 3) {
        ADD_FAILURE() << "no such reading was given between " << row.integer(0) << " and "
                      << row.integer(1) << ": " << (row.is_null(2) ? "NULL" : row.text(2));
      }
    }
  }

  static bool is_same(const std::string& text, const Statement& row) {
    constexpr double kOverload = 9.9e19;
    const double c = number(text, 0);
    const double d = number(text, text.find(',') + 1);
    if (c >= kOverload) return row.is_null(2) && (row.integer(4) & lcr_flag::kPrimaryOverload) != 0;
    if (row.is_null(2) || row.real(2) != c) return false;
    if (d >= kOverload) return row.is_null(3);
    return !row.is_null(3) && row.real(3) == d;
  }

  void expect_true_samples() {
    if (world_.samples.empty()) return;
    const Database db = world_.open();
    auto row = db.prepare("SELECT device_seq, force_N, travel_m FROM frame_sample").value();
    std::int64_t wrong = 0;
    while (row.step().value()) {
      const auto [first, last] = world_.samples.equal_range(row.integer(0));
      bool found = false;
      for (auto it = first; it != last; ++it) {
        const bool force = row.optional_real(1) == it->second.force_N;
        const bool travel =
            row.is_null(2) || std::abs(row.real(2) - it->second.travel_m.value_or(1e9)) < 1e-12;
        found = found || (force && travel);
      }
      if (!found && ++wrong <= 3) {
        ADD_FAILURE() << "no such sample was taken: number " << row.integer(0) << ", "
                      << row.real(1) << " N, " << row.real(2) << " m";
      }
    }
  }

  FaultWorld& world_;
  const Result<RunResult>& result_;
  FaultLimits limits_;
};

}  // namespace lcrig
