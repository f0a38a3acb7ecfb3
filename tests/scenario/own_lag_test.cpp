// SPDX-License-Identifier: Apache-2.0
// This computer stands still for a while in each situation of a run. Whatever arrived meanwhile
// comes at one instant after it. Neither the frame nor a person is blamed for that, and the run
// does what it would have done without it, or says that the link was silent because of this
// computer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/zwick/sim.hpp"
#include "model/plant.hpp"
#include "tests/support/kept_rig.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

enum class LagIn { standing, motion, pause, zero };
const char* word(LagIn in) {
  constexpr const char* kWords[] = {"standing", "motion", "pause", "zero"};
  return kWords[static_cast<std::size_t>(in)];
}

class LaggingWorld : public support::KeptRigWorld {
 protected:
  static constexpr const char* kProtocol =
      R"({ "format": "load-protocol/1", "name": "lags", "on_loss": "wait", "on_loss_timeout_s": 60,
      "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
      "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
        "aperture": "fast" }, "frame": { "rate_Hz": 50 } },
      "steps": [ { "id": "stay", "do": "record", "for_s": 5 },
                 { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
                 { "id": "go", "do": "ramp", "to": { "travel_mm": 1 }, "speed_mm_s": 0.1,
                   "timeout_s": 60 } ],
      "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5,
                     "timeout_s": 60 } ] })";

  void opened() override { instruments_->door()->frame_sim()->settings().answer_delay_s = 0.4; }

  // Nothing of this process runs for this time.
  void stand_still(Duration time) {
    const MonoTime end = clock.now() + time;
    bool over = false;
    const auto wait = [this, end, &over]() -> Task<> {
      co_await clock.wait_until(end);
      over = true;
    };
    asio::co_spawn(io, wait(), [](const std::exception_ptr&) {});
    io.restart();
    io.poll();
    while (clock.now() < end && clock.advance_to_next()) {
    }
    clock.run(io, [&] { return over; });
  }
  void go_on(Duration time) {
    for (const MonoTime end = clock.now() + time; clock.now() < end;) {
      clock.run_for(io, 20ms);
      for (const json& m : client_->take()) hear(m);
    }
  }
  void hear(const json& m) {
    if (m.value("method", "") == "run_ended") ended_ = m["params"];
    if (m.value("method", "") != "status") return;
    state_ = m["params"]["state"];
    step_ = m["params"]["step"];
    alarmed_ = alarmed_ || m["params"]["standstill"] == "not_confirmed";
  }
  template <class Holds>
  bool until(Holds holds) {
    for (int i = 0; i < 4000 && !holds(); ++i) go_on(20ms);
    return holds();
  }
  std::string all_events() const {
    const Database db = open_read_only(dir.file("d.db")).value();
    auto s = db.prepare("SELECT kind || ': ' || coalesce(detail, '') FROM event").value();
    std::string out;
    while (s.step().value()) out += std::string(s.text(0)) + "\n";
    return out;
  }

  json ended_;
  std::string state_, step_;
  bool alarmed_ = false;
};

class OwnLag : public LaggingWorld, public testing::WithParamInterface<std::tuple<LagIn, int>> {};

TEST_P(OwnLag, IsNotBlamedOnTheFrame) {
  const auto [in, lag_ms] = GetParam();
  const Duration lag = std::chrono::milliseconds(lag_ms);
  ASSERT_TRUE(answer(*client_, "watch").contains("result"));
  ASSERT_TRUE(answer(*client_, "run.start", start_request(kProtocol)).contains("result"));
  const std::string in_step = in == LagIn::standing ? "stay" : in == LagIn::zero ? "zero" : "go";
  ASSERT_TRUE(until([&] { return step_ == in_step && state_ == "running"; }));
  // The zero is ordered after the rest measurement, and answered up to 0.4 s later.
  go_on(in == LagIn::zero ? 540ms : 1s);
  if (in == LagIn::pause) {
    client_->call("run.pause");
    clock.run_for(io, 40ms);
  }
  stand_still(lag);
  if (in == LagIn::pause) {
    EXPECT_TRUE(until([&] { return state_ == "paused"; })) << state_;
    go_on(1s);
    EXPECT_EQ(state_, "paused");
    client_->call("run.resume");
  }
  EXPECT_TRUE(until([&] { return !ended_.is_null(); }));
  const std::string events = all_events();
  EXPECT_THAT(events, Not(HasSubstr("its samples show that it moves")));
  EXPECT_THAT(events, Not(HasSubstr("changed at the machine")));
  EXPECT_THAT(events, Not(HasSubstr("lost or changed meanwhile")));
  EXPECT_THAT(events, Not(HasSubstr("contradiction")));
  EXPECT_THAT(events, HasSubstr("lag")) << "it is named";
  EXPECT_FALSE(alarmed_);
  EXPECT_TRUE(ended_.value("stands", false)) << ended_;
  if (in != LagIn::zero) {
    EXPECT_EQ(ended_["exit_status"], "success") << ended_ << events;
  }
}

INSTANTIATE_TEST_SUITE_P(Each, OwnLag,
                         testing::Combine(testing::Values(LagIn::standing, LagIn::motion,
                                                          LagIn::pause, LagIn::zero),
                                          testing::Values(600, 1500, 5000)),
                         [](const auto& c) {
                           return fmt::format("{}_{}", word(std::get<0>(c.param)),
                                              std::get<1>(c.param));
                         });

// Under a held force, pressed and on the way down: whatever the computer did meanwhile, the run
// ends unloaded, or says that nobody knows.
enum class LongLagIn { load, hold, stay, clear };
const char* step_of(LongLagIn in) {
  constexpr const char* kSteps[] = {"load", "hold", "stay", "clear"};
  return kSteps[static_cast<std::size_t>(in)];
}

// The computer stands still for as long as half a minute, or longer than `finally` may take, while
// the specimen is loaded or on its way to be unloaded.
class LongLag : public LaggingWorld,
                public testing::WithParamInterface<std::tuple<LongLagIn, int>> {
 protected:
  static constexpr const char* kLoaded =
      R"({ "format": "load-protocol/1", "name": "loaded", "on_loss": "wait", "on_loss_timeout_s": 60,
      "limits": { "force_N": [-0.2, 1.5], "travel_mm": [-10, 10], "speed_mm_s": 2 },
      "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
        "aperture": "fast" }, "frame": { "rate_Hz": 50 } },
      "steps": [ { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
                 { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.05,
                   "back_off_mm": 0.2, "timeout_s": 120 },
                 { "id": "load", "do": "ramp", "to": { "force_N": 1.0 }, "speed_mm_s": 0.01,
                   "timeout_s": 300 },
                 { "id": "hold", "do": "hold", "hold": "force", "force_N": 1.0, "for_s": 5 },
                 { "id": "stay", "do": "record", "for_s": 5 } ],
      "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": 0 }, "speed_mm_s": 0.5,
                     "timeout_s": 110 } ] })";
};

TEST_P(LongLag, EndsUnloadedOrSaysThatItMayBeLoaded) {
  const auto [in, lag_ms] = GetParam();
  ASSERT_TRUE(answer(*client_, "watch").contains("result"));
  ASSERT_TRUE(answer(*client_, "run.start", start_request(kLoaded)).contains("result"));
  const std::string in_step = step_of(in);
  ASSERT_TRUE(until([&] { return step_ == in_step; })) << ended_ << all_events();
  go_on(1s);
  stand_still(std::chrono::milliseconds(lag_ms));
  const auto over = [&] { return !ended_.is_null(); };
  EXPECT_TRUE(until(over) || until(over)) << "in 160 s";
  go_on(2s);
  const double left_N = instruments_->door()->plant()->force_N(clock.now());
  if (lag_ms <= 30'000) {
    EXPECT_EQ(ended_["exit_status"], "success") << ended_ << all_events();
    EXPECT_LT(left_N, 0.01) << in_step;
  } else if (left_N >= 0.01) {
    EXPECT_THAT(ended_.value("reason", ""), HasSubstr("loaded"));
  }
}

INSTANTIATE_TEST_SUITE_P(Each, LongLag,
                         testing::Combine(testing::Values(LongLagIn::load, LongLagIn::hold,
                                                          LongLagIn::stay, LongLagIn::clear),
                                          testing::Values(1500, 30'000, 300'000)),
                         [](const auto& c) {
                           return fmt::format("{}_{}", step_of(std::get<0>(c.param)),
                                              std::get<1>(c.param));
                         });

}  // namespace
}  // namespace lcrig
