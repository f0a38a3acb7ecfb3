// SPDX-License-Identifier: Apache-2.0
// The time left that people are shown, over all protocols of the library and at every instant: it
// counts down with the time, or says that it cannot.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/daemon_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;

// Between two looks a time that stands still differs by more than the tolerance.
constexpr Duration kLook = 2s;
// People are shown whole seconds: a step may be late by half of one before the time says so.
constexpr double kTolerance_s = 0.6;
constexpr Duration kPersonThinks = 7s;

std::vector<std::string> library() {
  std::vector<std::string> out;
  for (const auto& file : std::filesystem::directory_iterator("protocols/library")) {
    if (file.path().extension() == ".json") out.push_back(file.path().stem());
  }
  std::ranges::sort(out);
  return out;
}

std::string text_of(const std::string& protocol) {
  std::ifstream file("protocols/library/" + protocol + ".json");
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Look {
  MonoTime at;
  RunStatus status;
};

class TimeLeft : public support::DaemonWorld, public testing::WithParamInterface<std::string> {
 protected:
  void see(const RunStatus& now) {
    const Look look{clock.now(), now};
    if (last_ && last_->status.run == now.run) compare(*last_, look);
    last_ = look;
  }
  void compare(const Look& a, const Look& b) {
    const double passed_s = to_seconds(b.at - a.at);
    const double fell_s = a.status.left_s - b.status.left_s;
    const std::string where = b.status.step_id + " at " + std::to_string(b.status.elapsed_s);
    ASSERT_GE(fell_s, -1e-9) << where << ": there is more left than before";
    if (!a.status.prompt.empty() || !b.status.prompt.empty()) return;  // `act` judges those
    const bool says_so = a.status.overdue || b.status.overdue;
    (says_so ? overdue_s_ : counted_s_) += passed_s;
    if (says_so || a.status.steps_done != b.status.steps_done) return;
    ASSERT_NEAR(fell_s, passed_s, kTolerance_s) << where << ": it does not count down";
  }
  // What a person does, after a while.
  void act(PlainClient& person, const RunStatus& now) {
    if (now.prompt.empty()) {
      asked_.reset();
      return;
    }
    EXPECT_TRUE(now.overdue) << "nobody knows how long a person takes: " << now.prompt;
    if (!asked_) asked_ = clock.now();
    if (clock.now() - *asked_ < kPersonThinks) return;
    asked_.reset();
    if (!now.question) return person.call("run.confirm");
    const Question& question = now.question->question;
    json value = true;
    if (question.type == AnswerType::number) value = question.min;
    if (question.type == AnswerType::choice) value = question.choices.front();
    if (question.type == AnswerType::line) value = "as it was";
    person.call("run.answer", json{{"value", value}});
  }

  std::optional<Look> last_;
  std::optional<MonoTime> asked_;
  double overdue_s_ = 0, counted_s_ = 0;
};

TEST_P(TimeLeft, CountsDownInEveryStepOrSaysThatItCannot) {
  PlainClient person(socket_path());
  const auto started = answer(person, "run.start", start_request(text_of(GetParam())));
  ASSERT_TRUE(started.contains("result")) << started;
  MonoTime next = clock.now();
  clock.run(io, [&] {
    if (clock.now() < next) return false;
    next = clock.now() + kLook;
    person.take();
    const auto now = app->status().run;
    if (now) {
      see(*now);
      act(person, *now);
    }
    return !now || HasFatalFailure() || clock.now() > MonoTime(24h);
  });
  ASSERT_TRUE(app->status().last_run);
  EXPECT_EQ(app->status().last_run->exit_status, ExitStatus::success)
      << app->status().last_run->reason;
  // The least share is that of `inspection`, which is mostly a search of unknown length.
  EXPECT_GT(counted_s_, 0.1 * (counted_s_ + overdue_s_)) << "it says always that it does not know";
}

INSTANTIATE_TEST_SUITE_P(Library, TimeLeft, testing::ValuesIn(library()), [](const auto& name) {
  std::string out = name.param;
  std::ranges::replace(out, '-', '_');
  return out;
});

}  // namespace
}  // namespace lcrig
