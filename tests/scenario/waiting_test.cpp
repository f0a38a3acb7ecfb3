// SPDX-License-Identifier: Apache-2.0
// Nothing waits while something may move: every way in which a run waits x everything that a
// gateway may do with STOP, at drawn instants and speeds, on the whole daemon in virtual time. The
// truth is the travel of the simulated bench. Whatever a client is told, a state in which the run
// waits is never shown while the true axis moves; what may move is an alarm in time; and the run
// waits rightly once the fault is over.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "drivers/zwick/sim.hpp"
#include "model/plant.hpp"
#include "tests/support/kept_rig.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;
using testing::HasSubstr;

enum class Wait {
  pause,
  pause_twice,
  pause_at_place,
  ask,
  record_until_confirmed,
  confirm_continuation,
  place_weight,
  meter_away,
  meter_away_holding_force,
  meter_away_then_pause,
  pause_then_meter_away,
  frame_away,
  pause_then_frame_away,
};

// A new state of a run does not compile here until it is known which scenes lead into it.
std::vector<Wait> scenes_of(RunState state) {
  switch (state) {
    case RunState::paused:
      return {Wait::pause, Wait::pause_twice, Wait::pause_at_place, Wait::pause_then_meter_away,
              Wait::pause_then_frame_away};
    case RunState::waiting_for_operator:
      return {Wait::ask, Wait::record_until_confirmed, Wait::confirm_continuation,
              Wait::place_weight};
    case RunState::waiting_for_instrument:
      return {Wait::meter_away, Wait::meter_away_holding_force, Wait::meter_away_then_pause,
              Wait::frame_away};
    case RunState::preparing:
    case RunState::running:
    case RunState::stopping:
    case RunState::holding_force:
    case RunState::finishing:
    case RunState::ended: break;
  }
  return {};
}

enum class Fault { none, stop_ignored, stop_late, stop_pretended, stop_silences };
constexpr Fault kFaults[] = {Fault::none, Fault::stop_ignored, Fault::stop_late,
                             Fault::stop_pretended, Fault::stop_silences};

const char* word(Wait wait) {
  constexpr const char* kWords[] = {"pause",
                                    "pause_twice",
                                    "pause_at_place",
                                    "ask",
                                    "record_until_confirmed",
                                    "confirm_continuation",
                                    "place_weight",
                                    "meter_away",
                                    "meter_away_holding_force",
                                    "meter_away_then_pause",
                                    "pause_then_meter_away",
                                    "frame_away",
                                    "pause_then_frame_away"};
  return kWords[static_cast<std::size_t>(wait)];
}

const char* word(Fault fault) {
  constexpr const char* kWords[] = {"none", "stop_ignored", "stop_late", "stop_pretended",
                                    "stop_silences"};
  return kWords[static_cast<std::size_t>(fault)];
}

void begin_fault(ZwickSimLies& lies, Fault fault) {
  switch (fault) {
    case Fault::none: return;
    case Fault::stop_ignored: lies.stop_ignored = true; return;
    case Fault::stop_late: lies.stop_late_s = 2; return;
    case Fault::stop_pretended: lies.stop_pretended = true; return;
    case Fault::stop_silences: lies.stop_silences = true; return;
  }
}

struct WaitingCell {
  Wait wait;
  Fault fault;
  std::uint64_t draw;
};

std::vector<WaitingCell> cells() {
  const char* more = std::getenv("LCRIG_WAITS");
  const std::uint64_t draws = more != nullptr ? std::strtoull(more, nullptr, 10) : 2;
  std::vector<WaitingCell> out;
  for (const std::string_view name : kWordsOf<RunState>) {
    for (const Wait wait : scenes_of(parse_word<RunState>(name).value())) {
      for (const Fault fault : kFaults) {
        for (std::uint64_t draw = 0; draw < draws; ++draw) out.push_back({wait, fault, draw});
      }
    }
  }
  return out;
}

class Waiting : public support::KeptRigWorld, public testing::WithParamInterface<WaitingCell> {
 protected:
  static constexpr Duration kStep = 5ms;
  static constexpr Duration kAlarm = 3s;  // after the wait was asked for
  static constexpr Duration kAnswer = 1500ms;  // after the request

  void opened() override {
    if (from_the_start_) lie();
  }
  void SetUp() override {
    cell_ = GetParam();
    random_.seed(1000 * cell_.draw + 10 * static_cast<std::uint64_t>(cell_.wait) +
                 static_cast<std::uint64_t>(cell_.fault));
    // Slower motions leave the tolerance of the samples after the look only (Standstill).
    speed_mm_s_ = 0.01 * std::pow(50, even());
    after_ = from_seconds(0.3 + 1.5 * even());
    KeptRigWorld::SetUp();
  }

  bool waits_after_a_step() const {
    return cell_.wait == Wait::ask || cell_.wait == Wait::record_until_confirmed ||
           cell_.wait == Wait::pause_at_place;
  }
  double even() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  void lie() {
    ZwickSim* frame = instruments_->door()->frame_sim();
    if (frame == nullptr) return;
    begin_fault(frame->faults.lies, cell_.fault);
    frame->poke();
  }
  void lie_no_more() {
    ZwickSim* frame = instruments_->door()->frame_sim();
    if (frame == nullptr) return;
    frame->faults.lies = ZwickSimLies();
    frame->poke();
  }
  // From now on the axis moves on after the end of a motion, as if DONE had come too early.
  void creep() {
    instruments_->door()->frame_sim()->faults.lies.creep_m_s = -speed_mm_s_ * 1e-3;
    instruments_->door()->frame_sim()->poke();
  }

  std::string protocol() const {
    const bool ends_soon = waits_after_a_step();
    const double lasts_s = to_seconds(after_) + (ends_soon ? 1 : 8);
    const std::string move = fmt::format(
        R"({{ "id": "go", "do": "ramp", "to": {{ "travel_mm": {} }}, "speed_mm_s": {}, "timeout_s": 600 }})",
        lasts_s * speed_mm_s_, speed_mm_s_);
    const std::string stay = R"({ "id": "stay", "do": "record", "for_s": 30 })";
    std::string steps = move + "," + stay;
    if (cell_.wait == Wait::ask) {
      steps = move + R"(, { "id": "ask", "do": "ask", "text": "Ready?", "answer": "confirmation",
                            "timeout_s": 600 },)" +
              stay;
    } else if (cell_.wait == Wait::record_until_confirmed) {
      steps = move +
              R"(, { "id": "ask", "do": "record", "until": "confirmed", "timeout_s": 600 },)" +
              stay;
    } else if (cell_.wait == Wait::place_weight) {
      steps = R"({ "id": "go", "do": "place_weight", "force_N": 0.5 },)" + stay;
    } else if (cell_.wait == Wait::meter_away_holding_force) {
      steps = R"({ "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02,
                   "back_off_mm": 0.05, "timeout_s": 600 },
                 { "id": "load", "do": "move_until", "until": { "force_N": 0.4 },
                   "speed_mm_s": 0.01, "timeout_s": 60 },
                 { "id": "go", "do": "hold", "hold": "force", "force_N": 0.4, "for_s": 60 })";
    }
    const bool rod = cell_.wait == Wait::place_weight;
    const std::string last =
        rod ? R"({ "id": "clear", "do": "place_weight", "mass_g": 0 })"
            : R"({ "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5, "timeout_s": 60 })";
    return R"({ "format": "load-protocol/1", "name": "waits", "on_loss": "wait",
      "on_loss_timeout_s": 600,
      "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
      "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
        "aperture": "fast" }, "frame": { "rate_Hz": )" +
           std::string(rod ? "10" : "50") + R"( } }, "steps": [ )" + steps +
           R"( ], "finally": [ )" + last + " ] }";
  }

  void begin() {
    ASSERT_TRUE(answer(*client_, "watch").contains("result"));
    const json started = answer(*client_, "run.start", start_request(protocol()));
    ASSERT_TRUE(started.contains("result")) << started;
    ASSERT_NE(instruments_, nullptr);
  }
  // Lets time pass while everything that is told is compared with the truth.
  void pass(Duration time) {
    for (const MonoTime end = clock.now() + time; clock.now() < end;) {
      clock.run_for(io, kStep);
      look();
      if (clock.now() >= next_status_) {
        next_status_ = clock.now() + 50ms;
        client_->call("status");
      }
      for (const json& message : client_->take()) hear(message);
    }
  }
  bool pass_until(const std::function<bool()>& holds, Duration longest = 120s) {
    for (const MonoTime end = clock.now() + longest; clock.now() < end && !holds();) pass(kStep);
    return holds();
  }
  void ask(const std::string& method) {
    client_->call(method);
    asked_ = clock.now();
    answered_ = json();
  }

  void look() {
    const Plant* plant = instruments_ ? instruments_->door()->plant() : nullptr;
    if (plant == nullptr) return;
    const double now_m = plant->travel_m(clock.now());
    if (std::abs(now_m - travel_m_) > 1e-10) {
      if (!moved_ || clock.now() - *moved_ > 2 * kStep) moving_since_ = clock.now();
      moved_ = clock.now();
    }
    travel_m_ = now_m;
  }
  // A message may be some steps older than the moment when it is read.
  bool moves() const {
    return moved_ && clock.now() - *moved_ <= kStep && clock.now() - moving_since_ > 2 * kStep;
  }

  void hear(const json& message) {
    if (message.value("method", "") == "status") return hear_status(message["params"]);
    if (message.value("method", "") == "run_ended") ended_ = message["params"];
    if (!message.contains("id")) return;
    if (message.contains("result") && message["result"].contains("instruments")) {
      status_ = message["result"];
      if (!status_["run"].is_null()) hear_status(status_["run"]);
      return judge_alarm();
    }
    answered_ = message;
    if (message.contains("error")) return;
    const json& result = message["result"];
    if (result.value("standing", false)) expect_still("the answer " + result.dump());
  }
  void hear_status(const json& run) {
    state_ = run["state"];
    standstill_ = run["standstill"];
    prompt_ = run.value("prompt", "");
    const auto state = parse_word<RunState>(state_);
    ASSERT_TRUE(state) << run;
    states_.insert(state_);
    if (waits(*state)) expect_still("the state " + state_);
    if (!prompt_.empty()) expect_still("the prompt " + prompt_);
  }
  void expect_still(const std::string& claim) {
    if (claimed_wrongly_ || !moves()) return;
    claimed_wrongly_ = true;
    ADD_FAILURE() << claim << " while the true axis moves at " << travel_m_ * 1e3 << " mm, "
                  << to_seconds(clock.now() - asked_.value_or(clock.now()))
                  << " s after the request";
  }
  bool critical() const {
    if (status_.is_null()) return false;
    if (!status_["run"].is_null()) {
      const std::string word = status_["run"]["standstill"];
      return word == "not_confirmed" || word == "unknown";
    }
    return !status_["last_run"].is_null() && !status_["last_run"].value("stands", true);
  }
  // From three seconds after the request on, a true motion that nothing but the fault explains is
  // an alarm.
  void judge_alarm() {
    if (!asked_ || !faulty_ || clock.now() - *asked_ < kAlarm || !moves()) return;
    if (is_in_step("clear") || critical() || std::exchange(missed_alarm_, true)) return;
    ADD_FAILURE() << to_seconds(clock.now() - *asked_)
                  << " s after the request the axis moves: " << status_["run"];
  }

  void await_motion() {
    ASSERT_TRUE(pass_until([this] { return state_ == "running" && is_in_step("go"); }));
    pass(after_);
  }
  bool is_in_step(const std::string& step) const {
    return !status_.is_null() && !status_["run"].is_null() && status_["run"]["step"] == step;
  }
  void unplug_meter() {
    instruments_->door()->unplug_meter();
    asked_ = clock.now();
  }
  void crash() {
    for (const char* suffix : {"", "-wal"}) {
      std::filesystem::copy_file(dir.file(std::string("d.db") + suffix),
                                 dir.file(std::string("cut.db") + suffix));
    }
    client_.reset();
    stop();
    start("cut.db");
    client_ = std::make_unique<PlainClient>(socket_path());
  }

  void set_scene();
  void end_scene();

  WaitingCell cell_{};
  std::mt19937_64 random_;
  double speed_mm_s_ = 0;
  Duration after_{};
  bool from_the_start_ = false, faulty_ = false, claimed_wrongly_ = false, missed_alarm_ = false;
  double travel_m_ = 0;
  std::optional<MonoTime> moved_, asked_;
  MonoTime next_status_{}, moving_since_{};
  json status_, answered_, ended_;
  std::string state_, standstill_, prompt_;
  std::set<std::string> states_;
};

// Brings the run to the instant at which it has to wait, with the fault.
void Waiting::set_scene() {
  begin();
  if (cell_.wait != Wait::place_weight) await_motion();
  faulty_ = true;
  if (waits_after_a_step()) creep();
  lie();
  switch (cell_.wait) {
    case Wait::pause: return ask("run.pause");
    case Wait::pause_twice:
      ask("run.pause");
      pass(300ms);
      return client_->call("run.pause");
    case Wait::pause_at_place:
      client_->call("run.pause", {{"at", "step"}});
      ASSERT_TRUE(pass_until([this] { return !is_in_step("go"); }));
      asked_ = clock.now();
      return;
    case Wait::ask:
    case Wait::record_until_confirmed:
      ASSERT_TRUE(pass_until([this] { return is_in_step("ask"); }));
      asked_ = clock.now();
      return;
    case Wait::confirm_continuation:
      crash();
      from_the_start_ = true;
      client_->call("watch");
      client_->call("run.resume", {{"run", 1}});
      asked_ = clock.now() + 3s;  // it is prepared first
      return;
    case Wait::place_weight: asked_ = clock.now(); return;
    case Wait::meter_away:
    case Wait::meter_away_holding_force: return unplug_meter();
    case Wait::meter_away_then_pause:
      unplug_meter();
      pass(200ms);
      return ask("run.pause");
    case Wait::pause_then_meter_away:
      ask("run.pause");
      pass(200ms);
      return instruments_->door()->unplug_meter();
    case Wait::frame_away:
      instruments_->door()->unplug_frame();
      asked_ = clock.now();
      return;
    case Wait::pause_then_frame_away:
      ask("run.pause");
      pass(200ms);
      return instruments_->door()->unplug_frame();
  }
}

// The fault is over, and what was away is back. A frame that moved on while it was away is not
// where it was, and a run that failed has said why.
void Waiting::end_scene() {
  faulty_ = false;
  lie_no_more();
  pass(500ms);
  if (cell_.wait == Wait::confirm_continuation && answered_.contains("error")) return;
  switch (cell_.wait) {
    case Wait::pause:
    case Wait::pause_twice:
    case Wait::pause_at_place:
      EXPECT_TRUE(pass_until([this] { return state_ == "paused" || !ended_.is_null(); }, 20s));
      return;
    case Wait::ask:
    case Wait::record_until_confirmed:
    case Wait::confirm_continuation:
    case Wait::place_weight:
      EXPECT_TRUE(pass_until(
          [this] { return state_ == "waiting_for_operator" || !ended_.is_null(); }, 20s));
      return;
    case Wait::meter_away:
    case Wait::meter_away_then_pause:
      EXPECT_TRUE(pass_until(
          [this] { return state_ == "waiting_for_instrument" || !ended_.is_null(); }, 20s));
      break;
    case Wait::meter_away_holding_force:
      EXPECT_EQ(state_, "holding_force") << "it moves to hold the force, and does not wait";
      break;
    case Wait::pause_then_meter_away: break;
    case Wait::frame_away:
    case Wait::pause_then_frame_away: instruments_->door()->plug_frame(); break;
  }
  if (ended_.is_null()) instruments_->door()->plug_meter();
  const bool paused = cell_.wait == Wait::meter_away_then_pause ||
                      cell_.wait == Wait::pause_then_meter_away ||
                      cell_.wait == Wait::pause_then_frame_away;
  const std::string then = paused ? "paused" : "running";
  EXPECT_TRUE(pass_until([&] { return state_ == then || !ended_.is_null(); }, 20s)) << state_;
}

TEST_P(Waiting, IsNeverClaimedWhileTheTrueAxisMoves) {
  set_scene();
  if (HasFatalFailure()) return;
  pass(6s);
  const bool asks = cell_.wait == Wait::pause || cell_.wait == Wait::pause_twice;
  if (asks) {
    ASSERT_FALSE(answered_.is_null()) << "nobody answered the pause";
    const bool confirmed = answered_.contains("result");
    // A motion that ended by itself is a standstill, too, and was confirmed by then.
    const bool may_stand = cell_.fault == Fault::stop_pretended;
    EXPECT_TRUE(confirmed == (cell_.fault == Fault::none) || may_stand) << answered_;
    if (!confirmed) {
      EXPECT_EQ(answered_["error"]["code"], -32012) << answered_;
      EXPECT_THAT(answered_["error"]["message"].get<std::string>(), HasSubstr("E-stop"));
    }
  }
  end_scene();
  if (cell_.wait == Wait::confirm_continuation && answered_.contains("error")) return;  // refused
  if (!ended_.is_null()) {
    EXPECT_NE(cell_.fault, Fault::none) << ended_;
    EXPECT_NE(ended_.value("reason", ""), "");
    return;
  }
  // It stands for good, or runs on.
  pass(2s);
  EXPECT_FALSE(critical()) << status_["run"];
  client_->call("run.freeze");
  EXPECT_TRUE(pass_until([this] { return !ended_.is_null(); }, 60s));
  EXPECT_TRUE(ended_.value("stands", false)) << ended_;
}

INSTANTIATE_TEST_SUITE_P(EachWay, Waiting, testing::ValuesIn(cells()), [](const auto& c) {
  return fmt::format("{}_{}_{}", word(c.param.wait), word(c.param.fault), c.param.draw);
});

TEST(WaitingItself, HasScenesForEachStateInWhichARunWaits) {
  for (const std::string_view name : kWordsOf<RunState>) {
    const RunState state = parse_word<RunState>(name).value();
    EXPECT_EQ(waits(state), !scenes_of(state).empty()) << name;
  }
}

}  // namespace
}  // namespace lcrig
