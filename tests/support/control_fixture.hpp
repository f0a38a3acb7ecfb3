// SPDX-License-Identifier: Apache-2.0
// A control handler that records its calls, for tests of the control server and client.
#pragma once

#include <fmt/ranges.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "daemon/control/handler.hpp"
#include "protocols/plan/plan.hpp"

namespace lcrig::support {

class FakeHandler : public ControlHandler,
                    public RunHandler,
                    public SteeringHandler,
                    public StoreHandler,
                    public MeterHandler {
 public:
  RunHandler& runs() override { return *this; }
  SteeringHandler& steering() override { return *this; }
  StoreHandler& store() override { return *this; }
  MeterHandler& meter() override { return *this; }
  Task<Result<RunStarted>> start_run(RunRequest request, PeerCredentials peer) override {
    calls.push_back("start " + request.protocol_name + " by " + request.operator_name);
    last_start = request;
    last_peer = peer;
    while (hold_start) co_await clock.wait_for(std::chrono::milliseconds(1));
    if (next_error) co_return fail(*next_error);
    RunStarted started;
    started.run = 7;
    if (after_start) after_start();
    co_return started;
  }
  Task<Result<StopAnswer>> pause(PeerCredentials) override {
    auto ok = done("pause");
    if (!ok) co_return fail(ok.error());
    co_return StopAnswer(StopState::standing, "paused");
  }
  Task<Result<StopAnswer>> pause_at(StopPlace place, PeerCredentials) override {
    co_return later("pause at " + std::string(to_string(place)));
  }
  Task<Result<StopAnswer>> stop_after(StopPlace place, std::string why, PeerCredentials) override {
    co_return later("stop after " + std::string(to_string(place)) + " " + why);
  }
  Task<Result<RunStarted>> resume(std::optional<std::int64_t> run, bool confirmed,
                                  PeerCredentials) override {
    const std::string which = run ? std::to_string(*run) : std::string("present");
    auto ok = done("resume " + which + (confirmed ? " confirmed" : ""));
    if (!ok) co_return fail(ok.error());
    RunStarted going;
    going.run = run ? *run + 1 : 7;
    co_return going;
  }
  Task<Result<StopAnswer>> abort(std::string why, PeerCredentials) override {
    hold_start = false;
    co_return stopped("abort " + why);
  }
  Task<Result<StopAnswer>> freeze(std::string why, PeerCredentials) override {
    co_return stopped("freeze " + why);
  }
  Task<Result<Plan>> plan_run(RunRequest request, PeerCredentials) override {
    last_plan = request;
    auto ok = done("plan " + request.protocol_name);
    if (!ok) co_return fail(ok.error());
    Plan plan;
    plan.duration_s = 1;
    co_return plan;
  }
  Task<Result<>> ask_instruments(PeerCredentials) override { co_return done("ask"); }
  Task<Result<>> confirm(PeerCredentials) override { co_return done("confirm"); }
  Task<Result<Answered>> answer(AnswerRequest request, PeerCredentials) override {
    auto ok = done("answer " + answer_words(request.value, "") +
                   (request.question ? " to " + std::to_string(*request.question) : ""));
    if (!ok) co_return fail(ok.error());
    Answered taken;
    taken.run = 7;
    taken.question.step_id = "thickness";
    taken.question.type = AnswerType::number;
    taken.question.unit = "um";
    taken.value = request.value;
    co_return taken;
  }
  ConfigView config_view() const override {
    ConfigView out;
    out.file = "lcrigd.json";
    out.of_daemon = true;
    return out;
  }
  Task<Result<std::vector<std::string>>> tag_run(TagRequest request, PeerCredentials) override {
    calls.push_back(fmt::format("{} {} {}", request.remove ? "untag" : "tag", request.run,
                                fmt::join(request.tags, " ")));
    co_return std::move(request.tags);
  }
  Task<Result<>> note_run(std::int64_t run, std::string text, PeerCredentials) override {
    co_return done("note " + std::to_string(run) + " " + text);
  }
  Task<Result<std::string>> add_specimen(SpecimenToAdd specimen, PeerCredentials) override {
    calls.push_back("specimen " + specimen.text);
    if (next_error) co_return fail(*next_error);
    co_return std::string("paper-9");
  }
  Task<Result<MeterCorrections>> correct(CorrectionKind kind, PeerCredentials) override {
    auto ok = done("correct " + std::string(to_string(kind)));
    if (!ok) co_return fail(ok.error());
    if (after_start) after_start();
    while (hold_start) co_await clock.wait_for(std::chrono::milliseconds(1));
    co_return corrections;
  }
  Task<Result<MeterCorrections>> look() override {
    auto ok = done("look at corrections");
    if (!ok) co_return fail(ok.error());
    co_return corrections;
  }
  DaemonStatus status() const override { return state; }
  Task<Result<std::string>> metrics() override {
    auto ok = done("metrics");
    if (!ok) co_return fail(ok.error());
    co_return std::string("lcrig_run_active 0\n");
  }

  std::vector<std::string> calls;
  RunRequest last_start, last_plan;
  PeerCredentials last_peer;
  DaemonStatus state;
  MeterCorrections corrections;
  std::optional<Error> next_error;
  bool hold_start = false;
  std::function<void()> after_start;  // called before the answer is sent
  RealClock clock;

 private:
  Result<StopAnswer> later(std::string call) {
    auto ok = done(std::move(call));
    if (!ok) return fail(ok.error());
    return StopAnswer(StopState::later, "it stops later");
  }
  Result<StopAnswer> stopped(std::string call) {
    auto ok = done(std::move(call));
    if (!ok) return fail(ok.error());
    return StopAnswer(StopState::standing, "stopped");
  }
  Result<> done(std::string call) {
    calls.push_back(std::move(call));
    if (next_error) return fail(*next_error);
    return {};
  }
};

}  // namespace lcrig::support
