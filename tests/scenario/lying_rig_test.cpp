// SPDX-License-Identifier: Apache-2.0
// A sensor, a drive or a gateway that says what is not true. The lie must be noticed, the frame
// stopped and the cause named. After that only those parts may move the frame that are still
// trusted. The truth comes from the simulated bench.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/detached.hpp>
#include <nlohmann/json.hpp>

#include "daemon/rig/bench_door.hpp"
#include "drivers/zwick/sim.hpp"
#include "model/plant.hpp"
#include "tests/support/protocol_text.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr double kLyingLimit_N = 1.0;
constexpr const char* kHandsOff = "until a person has looked";
// Loads, rests, measures and unloads in a step of its own.
std::string lied_to() {
  std::string text = with(kLoad, R"("within_s": 4 })", R"("within_s": 4 },
    { "id": "unload", "do": "move_until", "until": { "force_N": 0.1 }, "speed_mm_s": 0.01, "timeout_s": 60 })");
  return with(text, R"({ "id": "level")",
              R"({ "id": "rest", "do": "hold", "hold": "travel", "for_s": 10 },
    { "id": "level")");
}

// Records the truth during the run.
class LyingWorld final : public SessionWorld {
 public:
  explicit LyingWorld(std::string text = lied_to()) : SessionWorld(std::move(text)) {}
  ZwickSim& frame() { return lcrig::frame(*this); }
  void lie_in(const std::string& step, Duration after, std::function<void(ZwickSimLies&)> lie) {
    acts.push_back({step, after, [this, lie](SessionWorld&) {
                      lie(frame().faults.lies);
                      frame().poke();
                    }});
  }
  double largest_true_N() const { return largest_N_; }
  double true_N() const { return last_N_; }

 protected:
  void built() override {
    plant_ = session->instruments().door()->plant();
    asio::co_spawn(io, look(), asio::detached);
  }

 private:
  Task<> look() {
    while (!over_) {
      last_N_ = plant_->force_N(clock.now());
      largest_N_ = std::max(largest_N_, last_N_);
      co_await clock.wait_for(5ms);
    }
  }
  void ended() override { over_ = true; }

  const Plant* plant_ = nullptr;
  double largest_N_ = 0, last_N_ = 0;
  bool over_ = false;
};

struct Told {
  const char* name;
  const char* step;
  Duration after;
  std::function<void(ZwickSimLies&)> lie;
  const char* word;  // must be in the reason
  const char* end;  // must be in the reason if the specimen is left loaded; otherwise empty
};

const std::vector<Told>& lies() {
  static const std::vector<Told> all{
      {"frozen in the search", "contact", 1s, [](auto& l) { l.force_frozen = true; }, "frozen", ""},
      {"frozen in a load", "load", 1s, [](auto& l) { l.force_frozen = true; }, "frozen", ""},
      {"held in a load", "load", 1s, [](auto& l) { l.force_held = true; },
       "does not follow the way into the specimen", ""},
      {"a tenth of it in a load", "load", 0ms, [](auto& l) { l.force_gain = 0.1; },
       "does not follow the way into the specimen", ""},
      {"nothing of it in a load", "load", 5s, [](auto& l) { l.force_gain = 0; },
       "the load cell shows too little", ""},
      {"reversed in the search", "contact", 100ms, [](auto& l) { l.force_reversed = true; },
       "falls", ""},
      {"reversed while it stands", "rest", 3s, [](auto& l) { l.force_reversed = true; }, "falls",
       ""},
      {"reversed in a load", "load", 5s, [](auto& l) { l.force_reversed = true; }, "falls", ""},
      {"drive reversed in a load", "load", 1s, [](auto& l) { l.drive_reversed = true; },
       "against the command", kHandsOff},
      {"drive reversed on the way back", "unload", 0ms, [](auto& l) { l.drive_reversed = true; },
       "against the command", kHandsOff},
      {"creep after DONE", "level", 100ms, [](auto& l) { l.creep_m_s = 5e-6; }, "without a command",
       ""},
      {"DONE without a motion", "rest", 1s, [](auto& l) { l.done_unmoved = true; }, "DONE",
       "still loaded"},
      {"E-stop in a load", "load", 2s, [](auto& l) { l.estop = true; }, "E-stop", kHandsOff},
      {"CAPS are read once", "load", 2s, [](auto& l) { l.other_caps = true; }, "", ""}};
  return all;
}

void expect_each_lie_is_noticed(ForceClass cell) {
  for (const Told& lie : lies()) {
    SCOPED_TRACE(lie.name);
    LyingWorld world;
    world.bench.plant.force_class = cell;
    world.lie_in(lie.step, lie.after, lie.lie);
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    if (*lie.word == '\0') {
      EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
      continue;
    }
    EXPECT_EQ(r->exit_status, ExitStatus::fail);
    EXPECT_THAT(r->reason, HasSubstr(lie.word));
    EXPECT_LT(world.largest_true_N(), kLyingLimit_N);
    EXPECT_THAT(r->reason, HasSubstr(lie.end));
    if (*lie.end == '\0') {
      EXPECT_LT(world.true_N(), 0.01) << r->reason;
    }
  }
}

TEST(LyingRig, EachLieIsNoticedAndNamedAndTheTrueForceStaysWithinTheLimit) {
  expect_each_lie_is_noticed(ForceClass(1));
}

// The tolerances are wider, and none of the lies fits into them.
TEST(LyingRig, EachLieIsNoticedOnACellOfClass3Too) {
  expect_each_lie_is_noticed(ForceClass(3));
}

// Before contact is found this lie cannot be noticed, so the distance of a search is limited.
TEST(LyingRig, ASearchWithoutContactGoesBackToWhereItBegan) {
  LyingWorld world;
  world.lie_in("contact", 100ms, [](auto& l) { l.force_held = true; });
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_GT(world.largest_true_N(), kLyingLimit_N) << "it never touched: nothing was tried";
  EXPECT_LT(world.true_N(), 0.01) << r->reason;
  EXPECT_NEAR(world.real("SELECT travel_m FROM frame_sample ORDER BY seq DESC LIMIT 1"),
              world.real("SELECT travel_m FROM frame_sample ORDER BY seq LIMIT 1"), 20e-6);
}

TEST(LyingRig, ADriveThatStallsIsNoticedLongBeforeTheStepsTimeOut) {
  LyingWorld world;
  world.acts.push_back({"load", 1s, [](SessionWorld& w) { lcrig::frame(w).stall(); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_THAT(r->reason, HasSubstr("does not move"));
  EXPECT_LT(world.real("SELECT (MAX(at_mono_ns) - MIN(at_mono_ns)) / 1e9 FROM event "
                       "WHERE step_id = 'load' AND kind IN ('step_begin', 'contradiction')"),
            6);
}

TEST(LyingRig, ALateOrderThatIsObeyedInAPauseIsStopped) {
  LyingWorld world;
  world.lie_in("zero", 10ms, [](auto& l) { l.order_late_s = 1; });
  world.acts.push_back({"load", 200ms, [](SessionWorld& w) { w.interrupt(Interrupt::pause); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("without a command"));
  EXPECT_LT(world.largest_true_N(), 0.3);
  EXPECT_LT(world.true_N(), 0.01);
}

TEST(LyingRig, ATareThatIsLostWhileItStandsIsNoticedByTheJump) {
  LyingWorld world;
  world.bench.plant.force_offset_N = 0.3;
  world.acts.push_back({"rest", 4s, [](SessionWorld& w) {
                          ZwickSim& f = lcrig::frame(w);
                          f.faults.lose_tare = true;
                          f.poke();
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("jumped"));
  EXPECT_LT(world.true_N(), 0.01);
}

// A drift of 5 mN/s. A search that stops at a fixed 20 mN would find contact 4 s too early.
TEST(LyingRig, ADriftIsFollowedAndNotTakenForContact) {
  LyingWorld world;
  world.bench.plant.force_drift_N_s = 5e-3;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  const std::string found = world.text("SELECT detail FROM event WHERE kind = 'contact'");
  ASSERT_FALSE(found.empty()) << r->reason;
  const double at_m = nlohmann::json::parse(found).at("travel_m");
  EXPECT_NEAR(at_m, world.bench.plant.contact_travel_m, 0.1e-3) << r->reason;
}

TEST(LyingRig, ADriftThatBeginsInTheSearchFindsNoContactInTheAir) {
  for (const double drift_N_s : {2e-3, -2e-3}) {
    SCOPED_TRACE(drift_N_s);
    LyingWorld world;
    world.lie_in("contact", 2s, [=](auto& l) { l.force_drift_N_s = drift_N_s; });
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_GE(world.count("SELECT COUNT(*) FROM event WHERE kind = 'no_contact'"), 1);
    const std::string found = world.text("SELECT detail FROM event WHERE kind = 'contact'");
    ASSERT_FALSE(found.empty()) << r->reason;
    const double at_m = nlohmann::json::parse(found).at("travel_m");
    EXPECT_NEAR(at_m, world.bench.plant.contact_travel_m, 0.1e-3) << r->reason;
  }
}

TEST(LyingRig, AThresholdWithinTheNoiseIsRefusedWithTheFigure) {
  LyingWorld world;
  world.bench.plant.force_noise_N = 0.02 / 3;
  const auto r = world.run();
  ASSERT_FALSE(r);
  EXPECT_THAT(r.error().what, HasSubstr("scatters by"));
  EXPECT_THAT(r.error().what, HasSubstr("at least 0.03"));
}

TEST(LyingRig, TheTolerancesAreOfThePlanAndStoredWithTheRun) {
  LyingWorld world;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  const auto plan =
      nlohmann::json::parse(world.text("SELECT detail FROM event WHERE kind = 'plan'"));
  const auto watch =
      nlohmann::json::parse(world.text("SELECT detail FROM event WHERE kind = 'watch'"));
  for (const char* name : {"stall_s", "against_mm", "standing_mm", "order_travel_mm", "reply_s"}) {
    EXPECT_EQ(plan.at("watch").at(name), watch.at(name)) << name;
  }
  EXPECT_LT(watch.at("frozen_force_s"), 1.0);
}

// Once the search has stopped in contact, the drive runs the wrong way and shows that it obeys.
class MirrorWorld final : public SessionWorld {
 public:
  static constexpr double kLimit_N = 0.25, kThreshold_N = 0.05;
  MirrorWorld() : SessionWorld(text()) {}
  double largest_true_N() const { return plant_->peak_answered_N(clock.now()); }

 protected:
  void built() override {
    plant_ = session->instruments().door()->plant();
    asio::co_spawn(io, look(), asio::detached);
  }

 private:
  static std::string text() {
    const std::string slow = with(kLoad, R"("speed_mm_s": 0.2, "force_N": 0.02)",
                                  R"("speed_mm_s": 0.02, "force_N": 0.05)");
    return with(with(slow, "[-0.2, 1.0]", "[-0.2, 0.25]"), R"({ "force_N": 0.5 })",
                R"({ "force_N": 0.1 })");
  }
  Task<> look() {
    double before_N = 0;
    while (!over_) {
      const double now_N = plant_->force_N(clock.now());
      if (now_N > 0.9 * kThreshold_N && now_N == before_N) break;
      before_N = now_N;
      co_await clock.wait_for(20ms);
    }
    lcrig::frame(*this).faults.lies.drive_mirrored = true;
    lcrig::frame(*this).poke();
  }
  void ended() override { over_ = true; }

  const Plant* plant_ = nullptr;
  bool over_ = false;
};

// The force on each way back would pass for a drift of the cell: a new search presses deeper.
TEST(LyingRig, ADriveThatPressesOnItsWaysBackAndShowsThatItObeysIsNotBelieved) {
  MirrorWorld world;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("the force rises against the command"));
  EXPECT_THAT(r->reason, HasSubstr(kHandsOff));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id = 'clear'"), 0) << r->reason;
  EXPECT_LE(world.count("SELECT COUNT(*) FROM event WHERE kind = 'no_contact'"), 2);
  EXPECT_GT(world.largest_true_N(), MirrorWorld::kThreshold_N);
  EXPECT_LT(world.largest_true_N(), MirrorWorld::kLimit_N) << r->reason;
}

constexpr const char* kPad =
    R"({ "format": "specimen/1", "name": "pad", "disc_diameter_mm": 4, "faces": "free",
    "materials": { "P": { "relative_permittivity": 2.75, "youngs_modulus_kPa": 3687.87,
    "poisson_ratio": 0.495 } },
    "capacitors": [ { "layers": [ { "material": "P", "thickness_um": 161.4 } ] } ] })";

// The first step back of a coarse travel leaves this contact at once, so its slope is not known.
// That the force fell there proves enough for the watch.
TEST(LyingRig, AForceThatIsHeldIsNoticedThoughTheStiffnessOfTheContactIsNotKnown) {
  constexpr double kHardLimit_N = 5;
  LyingWorld world(
      R"({ "format": "load-protocol/1", "name": "hard",
      "limits": { "force_N": [-0.3, 5], "gap_mm": [-1, 4], "speed_mm_s": 2 },
      "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
      "aperture": "fast" }, "frame": { "rate_Hz": 50 } },
      "steps": [ { "id": "zero", "do": "zero", "force": true },
      { "id": "contact", "do": "find_contact", "speed_mm_s": 0.02, "force_N": 0.15,
      "back_off_mm": 0.1, "timeout_s": 600, "within_mm": 1 },
      { "id": "load", "do": "move_until", "until": { "force_N": 2 }, "speed_mm_s": 0.01,
      "timeout_s": 600 } ],
      "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 1 }, "speed_mm_s": 0.3,
      "timeout_s": 250 } ] })");
  world.bench = *parse_bench(
      R"({ "format": "bench/1", "name": "hard", "error_tolerance": 0.5,
      "fixture": { "probe_diameter_mm": 4 }, "frame": { "contact_travel_mm": 0.2,
      "stiffness_N_mm": 1679.53, "travel_resolution_um": 2 }, "meter": {} })",
      "hard");
  world.specimen_name = "pad";
  world.specimen_text = kPad;
  world.lie_in("load", 0ms, [](auto& l) { l.force_held = true; });
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind = 'stiffness' AND "
                        "detail LIKE '%\"at_least_N_m\":null%'"),
            1);
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("does not follow the way into the specimen"));
  EXPECT_LT(world.largest_true_N(), kHardLimit_N);
  EXPECT_LT(world.true_N(), 0.01) << r->reason;
}

// A pad on a stiff frame that stops late: the search is slowed down to about 0.9 um/s. The travel
// is shown in digits of `digit_um`, and no motion has shown them yet.
class CoarseWorld final : public SessionWorld {
 public:
  CoarseWorld(double digit_um, double contact_mm, std::int64_t with_seed)
      : SessionWorld(kCoarseSearch), seed_(with_seed) {
    bench = *parse_bench(
        fmt::format(
            R"({{ "format": "bench/1", "name": "coarse", "error_tolerance": 0.5,)"
            R"( "fixture": {{ "probe_diameter_mm": 4 }}, "frame": {{)"
            R"( "contact_travel_mm": {}, "stiffness_N_mm": 1679.53, "drive_lag_ms": 230.69,)"
            R"( "deceleration_mm_s2": 16.54, "travel_resolution_um": {},)"
            R"( "force_noise_mN": 5.17, "force_resolution_mN": 0.52, "rate_max_Hz": 10 }},)"
            R"( "meter": {{}} }})",
            contact_mm, digit_um),
        "coarse");
    specimen_name = "pad";
    specimen_text = kPad;
  }
  double peak_N() const {
    return session->instruments().door()->plant()->peak_answered_N(clock.now());
  }

 private:
  static constexpr const char* kCoarseSearch =
      R"({ "format": "load-protocol/1", "name": "coarse",
      "limits": { "force_N": [-0.3, 0.79], "gap_mm": [-3, 4], "speed_mm_s": 5 },
      "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
      "aperture": "fast" }, "frame": { "rate_Hz": 10 } },
      "steps": [ { "id": "zero", "do": "zero", "force": true },
      { "id": "contact", "do": "find_contact", "speed_mm_s": 0.27, "force_N": 0.1857,
      "back_off_mm": 0.155, "timeout_s": 36000, "slow_down": true, "within_mm": 1 } ],
      "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 1 }, "speed_mm_s": 0.3,
      "timeout_s": 250 } ] })";
  void adjust(SimRequest& sim, Recorder::Options& /*recorder*/) override { sim.seed = seed_; }
  std::int64_t seed_;
};

TEST(LyingRig, ACoarseTravelInASlowSearchIsNoStall) {
  for (const double digit_um : {2.0, 10.0}) {
    for (std::int64_t seed = 1; seed <= 3; ++seed) {
      CoarseWorld world(digit_um, 0.05, seed);
      const auto r = world.run();
      ASSERT_TRUE(r) << r.error().what;
      EXPECT_EQ(r->exit_status, ExitStatus::success) << digit_um << " um: " << r->reason;
    }
  }
}

TEST(LyingRig, ADriveThatStallsBeforeItsDigitIsKnownIsNoticedAfterSomeMicrometres) {
  CoarseWorld world(10, 0.05, 1);
  world.acts.push_back({"contact", 3s, [](SessionWorld& w) { lcrig::frame(w).stall(); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_THAT(r->reason, HasSubstr("does not move"));
  EXPECT_THAT(r->reason, HasSubstr(kHandsOff));
  EXPECT_LT(world.real("SELECT (MAX(at_mono_ns) - MIN(at_mono_ns)) / 1e9 FROM event "
                       "WHERE step_id = 'contact' AND kind IN ('step_begin', 'contradiction')"),
            60);
}

// As long as the travel does not change, the force bounds what the drive may do: the device stops
// the search by itself.
TEST(LyingRig, ATravelThatNeverChangesLetsNothingBePressedBeyondTheLimit) {
  for (const double contact_mm : {0.005, 0.02, 0.05}) {
    CoarseWorld world(1e4, contact_mm, 1);
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::fail);
    EXPECT_LT(world.peak_N(), 0.79) << r->reason;
  }
}

}  // namespace
}  // namespace lcrig
