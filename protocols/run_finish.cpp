// SPDX-License-Identifier: Apache-2.0
// How a run ends, whatever happened before: the frame stopped, `finally`, the meter safe.
#include <fmt/format.h>

#include <boost/asio/experimental/awaitable_operators.hpp>
#include <utility>
#include <variant>

#include "protocols/run.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;

}  // namespace

Task<> Run::stop_frame() {
  if (!setup_.frame.capabilities().motion) {
    standing_ = true;
    co_return;
  }
  auto stopped = co_await setup_.frame.stop();
  standing_ = stopped.has_value();
  event(stopped ? "stopped" : "stop_failed", stopped ? "" : stopped.error().what);
}

Task<> Run::finish(std::optional<InterruptRequest> stop, RunResult& result) {
  finishing_ = true;
  stop_pending_ = false;
  progress_.state = RunState::finishing;
  // A stop of the last instant is one, and whoever froze a run that was stopped means it.
  for (InterruptRequest& late : pending_) {
    const bool stops = late.kind != Interrupt::pause && late.kind != Interrupt::loss;
    if (late.kind == Interrupt::freeze || (stops && !stop)) stop = std::move(late);
  }
  pending_.clear();
  co_await stop_frame();
  if (frame_away_) co_await recover_frame_for_finally();
  result.exit_status = "success";
  if (stop) {
    const bool wanted = stop->kind == Interrupt::abort || stop->kind == Interrupt::freeze;
    result.exit_status = wanted ? "abort" : "fail";
    result.reason = fmt::format("{}: {}", to_string(stop->kind), stop->why);
    result.code = stop->code;
    if (stop->kind == Interrupt::limit) guard_.allow_return();
    auto line = co_await setup_.frame.resync();
    if (!line) event("retry", line.error().what);
  }
  const bool frozen = stop && stop->kind == Interrupt::freeze;
  if (frame_away_ && !frozen) {
    if (!stop) {  // every step had ended well
      result.exit_status = "fail";
      result.reason = frame_away_->why.what;
      result.code = frame_away_->why.code;
    }
    result.reason += "; `finally` did not run: the frame is not there";
  } else if (!frozen) {
    co_await run_finally(result);
  }
  co_await stop_frame();
  co_await sampler_.stop();
  if (!meter_away_) {
    auto safe = co_await setup_.lcr.make_safe();
    if (!safe) event("retry", safe.error().what);
  }
  setup_.frame.set_listener(nullptr);
  over_ = true;
  progress_.state = RunState::ended;
}

// Runs whatever happened before; has its own deadline, after which the frame stays where it is.
Task<> Run::run_finally(RunResult& result) {
  const MonoTime deadline = setup_.clock.now() + setup_.protocol.finally_timeout;
  StepCursor cursor(setup_.protocol.finally_steps, setup_.environment);
  auto r = co_await (run_steps(cursor) || setup_.clock.wait_until(deadline));
  std::string why;
  Errc code = Errc::no_reply;
  if (r.index() == 1) {
    why = fmt::format("`finally` did not end in {:.0f} s; the frame was stopped where it stood",
                      to_seconds(setup_.protocol.finally_timeout));
  } else if (const auto& stop = std::get<0>(r)) {
    why = fmt::format("in `finally`: {}", stop->why);
    code = stop->code;
  }
  if (why.empty()) co_return;
  event("fault", why);
  if (result.exit_status == "success") {
    result.exit_status = "fail";
    result.code = code;
  }
  result.reason += (result.reason.empty() ? "" : "; ") + why;
}

}  // namespace lcrig
