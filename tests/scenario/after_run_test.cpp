// SPDX-License-Identifier: Apache-2.0
// A run that ended while its frame was not known to stand: STOP goes on being sent, nothing begins,
// no person is asked to touch the rig, and every word says so, until the frame confirms standstill.
// The truth is the travel of the simulated bench.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "drivers/zwick/sim.hpp"
#include "model/plant.hpp"
#include "tests/support/kept_rig.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;

// What is wrong when the run is stopped. Each is over after kFaulty.
enum class AfterFault { stop_ignored, stop_late, stop_pretended, stop_silences, link_lost };

const char* word(AfterFault fault) {
  constexpr const char* kWords[] = {"stop_ignored", "stop_late", "stop_pretended", "stop_silences",
                                    "link_lost"};
  return kWords[static_cast<std::size_t>(fault)];
}

class AfterRun : public support::KeptRigWorld, public testing::WithParamInterface<AfterFault> {
 protected:
  static constexpr Duration kFaulty = 20s;
  static constexpr const char* kLongWay =
      R"({ "format": "load-protocol/1", "name": "long-way", "on_loss": "abort",
      "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
      "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
        "aperture": "fast" }, "frame": { "rate_Hz": 50 } },
      "steps": [ { "id": "go", "do": "ramp", "to": { "travel_mm": 4 }, "speed_mm_s": 0.05,
                   "timeout_s": 200 } ],
      "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5,
                     "timeout_s": 60 } ] })";

  static json entry(const std::string& specimen) {
    json out = start_request(kLongWay);
    out["specimen"] = specimen;
    return out;
  }
  ZwickSim& frame() { return *instruments_->door()->frame_sim(); }
  void set_fault(bool on) {
    ZwickSimLies lies;
    switch (GetParam()) {
      case AfterFault::stop_ignored: lies.stop_ignored = true; break;
      case AfterFault::stop_late: lies.stop_late_s = 15; break;
      case AfterFault::stop_pretended: lies.stop_pretended = true; break;
      case AfterFault::stop_silences: lies.stop_silences = true; break;
      case AfterFault::link_lost:
        on ? instruments_->door()->unplug_frame() : instruments_->door()->plug_frame();
        return;
    }
    frame().faults.lies = on ? lies : ZwickSimLies();
    frame().poke();
  }
  void look() {
    if (!instruments_) return;
    const double now_m = instruments_->door()->plant()->travel_m(clock.now());
    if (known_ && std::abs(now_m - travel_m_) > 1e-10) moved_ = clock.now();
    travel_m_ = now_m;
    known_ = true;
  }
  // Lets time pass while the truth is watched, and asks for the status.
  void go_on(Duration time) {
    for (const MonoTime end = clock.now() + time; clock.now() < end;) {
      clock.run_for(io, 5ms);
      look();
      for (const json& m : client_->take()) {
        if (m.value("method", "") == "run_ended") ended_ = m["params"];
      }
    }
  }
  json ask(const std::string& method, const json& params = json::object()) {
    json out = answer(*client_, method, params);
    look();
    return out;
  }
  // A person goes on with the second entry. That asks for its specimen only once the frame stands.
  void start_queue() {
    if (std::exchange(started_, true)) return;
    const json got = ask("queue.start", {{"head", "skip"}});
    EXPECT_TRUE(got.contains("result")) << got;
  }
  bool stands() const { return !moved_ || clock.now() - *moved_ > 100ms; }

  // Begins the first entry of the queue, and freezes it with the fault.
  void freeze_with_fault();

  bool known_ = false, started_ = false;
  double travel_m_ = 0;
  std::optional<MonoTime> moved_;
  json ended_;
};

void AfterRun::freeze_with_fault() {
  ASSERT_TRUE(ask("watch").contains("result"));
  for (const char* specimen : {"paper-1", "paper-2"}) {
    const json queued = ask("queue.add", entry(specimen));
    ASSERT_TRUE(queued.contains("result")) << queued;
  }
  ASSERT_TRUE(ask("queue.start").contains("result"));
  const json gate = ask("status")["result"]["queue"];
  ASSERT_TRUE(ask("queue.answer", {{"text", "paper-1"}}).contains("result")) << gate;
  for (int i = 0; i < 200 && !instruments_; ++i) clock.run_for(io, 50ms);
  ASSERT_NE(instruments_, nullptr) << ask("status");
  for (int i = 0; i < 200 && !moved_; ++i) go_on(100ms);
  ASSERT_TRUE(moved_) << ask("status");
  go_on(2s);
  set_fault(true);
  client_->call("run.freeze");
  for (int i = 0; i < 200 && ended_.is_null(); ++i) go_on(100ms);
  ASSERT_FALSE(ended_.is_null());
}

TEST_P(AfterRun, StopIsSentAndNothingBeginsUntilTheFrameStands) {
  freeze_with_fault();
  if (HasFatalFailure()) return;
  EXPECT_FALSE(ended_.value("stands", true)) << ended_;
  const MonoTime began = clock.now();
  std::int64_t stops = frame().stops();
  int looks = 0;
  bool confirmed = false;
  for (; clock.now() < began + kFaulty && !confirmed; ++looks) {
    go_on(1s);
    const json status = ask("status")["result"];
    EXPECT_TRUE(status["run"].is_null()) << status["run"];
    confirmed = status["last_run"].value("stands", true);
    if (confirmed) break;
    EXPECT_EQ(status["queue"].value("prompt", ""), "") << "no gate while it may move";
    const json refused = ask("run.start", start_request(kLongWay));
    ASSERT_TRUE(refused.contains("error")) << refused;
    start_queue();
  }
  EXPECT_FALSE(confirmed && !stands()) << "at " << travel_m_;
  if (GetParam() == AfterFault::stop_ignored || GetParam() == AfterFault::stop_pretended) {
    EXPECT_FALSE(confirmed);
    EXPECT_GE(6 * (frame().stops() - stops), 5 * (looks - 2))
        << "once a second, or after each look";
    const json abort = ask("run.abort");
    EXPECT_THAT(abort["error"]["message"].get<std::string>(), HasSubstr("E-stop"));
  }
  set_fault(false);
  for (int i = 0; i < 50 && !confirmed; ++i) {
    go_on(100ms);
    confirmed = ask("status")["result"]["last_run"].value("stands", true);
  }
  EXPECT_TRUE(confirmed);
  EXPECT_TRUE(stands()) << "at " << travel_m_;
  const json status = ask("status")["result"];
  EXPECT_GT(status["last_run"].value("stood_after_s", 0.0), 0) << status["last_run"];
  go_on(2s);
  EXPECT_EQ(count("SELECT count(*) FROM run_note WHERE text LIKE '%confirmed standstill%'"), 1);
  start_queue();
  go_on(1s);
  const json queue = ask("status")["result"]["queue"];
  EXPECT_NE(queue.value("prompt", ""), "") << "now a person may act: " << queue;
}

// The service ends while the frame may move: it does not wait for a frame that never answers.
TEST_P(AfterRun, TheDaemonEndsWhileTheFrameMayMove) {
  freeze_with_fault();
  if (HasFatalFailure()) return;
  const MonoTime asked = clock.now();
  client_.reset();
  stop();
  RecordProperty("to_end_s", std::to_string(to_seconds(clock.now() - asked)));
  EXPECT_LT(clock.now() - asked, 20s) << "longer than a few attempts to stop";
  start("again.db");
}

INSTANTIATE_TEST_SUITE_P(Each, AfterRun,
                         testing::Values(AfterFault::stop_ignored, AfterFault::stop_late,
                                         AfterFault::stop_pretended, AfterFault::stop_silences,
                                         AfterFault::link_lost),
                         [](const auto& c) { return word(c.param); });

}  // namespace
}  // namespace lcrig
