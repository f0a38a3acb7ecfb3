// SPDX-License-Identifier: Apache-2.0
// Lines of the control socket, read as the daemon reads them and as a client does. Every call is
// made, with a handler that does nothing.
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "daemon/control/dispatch.hpp"
#include "protocols/plan/plan.hpp"
#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {

namespace {

using nlohmann::json;

class IdleHandler final : public ControlHandler,
                          public RunHandler,
                          public SteeringHandler,
                          public StoreHandler,
                          public MeterHandler {
 public:
  RunHandler& runs() override { return *this; }
  SteeringHandler& steering() override { return *this; }
  StoreHandler& store() override { return *this; }
  MeterHandler& meter() override { return *this; }
  Task<Result<RunStarted>> start_run(RunRequest request, PeerCredentials) override {
    start = std::move(request);
    co_return RunStarted();
  }
  Task<Result<StopAnswer>> pause(PeerCredentials) override {
    co_return StopAnswer(StopState::standing, "");
  }
  Task<Result<StopAnswer>> pause_at(StopPlace, PeerCredentials) override {
    co_return StopAnswer(StopState::standing, "");
  }
  Task<Result<StopAnswer>> stop_after(StopPlace, std::string, PeerCredentials) override {
    co_return StopAnswer(StopState::standing, "");
  }
  Task<Result<Answered>> answer(AnswerRequest, PeerCredentials) override { co_return Answered(); }
  Task<Result<RunStarted>> resume(std::optional<std::int64_t>, bool, PeerCredentials) override {
    co_return RunStarted();
  }
  Task<Result<StopAnswer>> abort(std::string, PeerCredentials) override {
    co_return StopAnswer(StopState::standing, "");
  }
  Task<Result<StopAnswer>> freeze(std::string, PeerCredentials) override {
    co_return StopAnswer(StopState::standing, "");
  }
  Task<Result<Plan>> plan_run(RunRequest, PeerCredentials) override { co_return Plan(); }
  Task<Result<>> ask_instruments(PeerCredentials) override { co_return Result<>(); }
  Task<Result<>> confirm(PeerCredentials) override { co_return Result<>(); }
  ConfigView config_view() const override { return {}; }
  Task<Result<std::vector<std::string>>> tag_run(TagRequest request, PeerCredentials) override {
    co_return std::move(request.tags);
  }
  Task<Result<>> note_run(std::int64_t, std::string, PeerCredentials) override {
    co_return Result<>();
  }
  Task<Result<std::string>> add_specimen(SpecimenToAdd specimen, PeerCredentials) override {
    co_return std::move(specimen.text);
  }
  Task<Result<MeterCorrections>> correct(CorrectionKind, PeerCredentials) override {
    co_return MeterCorrections();
  }
  Task<Result<MeterCorrections>> look() override { co_return MeterCorrections(); }
  DaemonStatus status() const override { return DaemonStatus(); }
  Task<Result<std::string>> metrics() override { co_return std::string(); }
  std::optional<RunRequest> start;
};

// An answer is one line of JSON. If it is an error, it has a message and a hint.
void require_good_line(const std::string& line) {
  require(line.ends_with('\n') && line.find('\n') == line.size() - 1, "not one line: " + line);
  const json answer = json::parse(line, nullptr, false);
  require(answer.is_object() && answer.contains("id"), "no JSON-RPC answer: " + line);
  const auto error = answer.find("error");
  require(answer.contains("result") != (error != answer.end()), "neither result nor error");
  if (error == answer.end()) return;
  require_good_message((*error)["message"].get<std::string>());
  require(!(*error)["data"]["hint"].get<std::string>().empty(), "an error without a hint");
}

void call_it(ControlCall call) {
  static asio::io_context io{1};
  IdleHandler handler;
  const bool wants_answer = call.wants_answer;
  std::optional<std::string> line;
  PeerCredentials peer;
  peer.user = "fuzz";
  asio::co_spawn(io, answer_control_call(handler, std::move(call), std::move(peer)),
                 [&line](const std::exception_ptr& error, std::optional<std::string> answer) {
                   if (error) std::rethrow_exception(error);
                   line = std::move(answer);
                 });
  io.restart();
  io.run();
  require(line.has_value() == wants_answer, "an answer that nobody wanted, or none");
  if (line) require_good_line(*line);
  if (!handler.start) return;
  const json wire = to_json(*handler.start);
  const auto again = parse_run_request(wire);
  require(again && to_json(*again) == wire, "run.start changed on its way");
}

template <class Parse>
void read_as_client(const json& value, Parse parse) {
  const auto news = parse(value);
  if (!news) return require_good_message(news.error());
  const json wire = to_json(*news);
  const auto again = parse(wire);
  require(again.has_value(), again ? "" : "our own message is refused: " + again.error().what);
  require(to_json(*again) == wire, "a message changed on its way: " + wire.dump());
}

}  // namespace

void read_control(std::string_view input) {
  auto call = parse_control_call(input);
  if (call) {
    call_it(std::move(*call));
  } else {
    require_good_line(call.error());
  }
  const json value = json::parse(input, nullptr, false);
  if (!value.is_object()) return;
  read_as_client(value, parse_run_status);
  read_as_client(value, parse_run_outcome);
  read_as_client(value, parse_run_event);
  read_as_client(value, parse_daemon_status);
}

}  // namespace lcrig::fuzz
