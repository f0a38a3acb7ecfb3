// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/drill.hpp"

#include <numeric>
#include <utility>

namespace lcrig {

Result<std::unique_ptr<FaultDrill>> FaultDrill::make(VirtualClock& clock, const std::string& text,
                                                     const std::string& name) {
  auto script = parse_fault_script(text, name);
  if (!script) return fail(script.error());
  return std::unique_ptr<FaultDrill>(new FaultDrill(clock, std::move(*script)));
}

Result<> FaultDrill::attach(asio::any_io_executor executor, FaultBench& bench) {
  FaultStage stage;
  stage.has_frame = bench.has_frame();
  if (auto fits = check_stage(script_, stage); !fits) return fits;
  const auto told = [this](MonoTime at, const std::string& text) { note(at, text); };
  player_ = std::make_unique<FaultPlayer>(std::move(executor), clock_, bench, &surroundings_,
                                          script_, told);
  return {};
}

void FaultDrill::note(MonoTime at, const std::string& text) {
  RunEvent event(at, EventKind::injected, step_, "fault injected: " + text);
  if (sink_ == nullptr) {
    early_.push_back(std::move(event));
  } else {
    sink_->event(event);
  }
}

void FaultDrill::begin(RunSink& sink) {
  sink_ = &sink;
  for (const RunEvent& event : early_) sink.event(event);
  player_->begin();
}

void FaultDrill::enter_step(const RunProgress& progress) {
  step_ = progress.step_id;
  const bool finishing = progress.state == RunState::finishing;
  player_->enter_step(progress.step_id, progress.step_kind, finishing);
}

Task<> FaultDrill::end() {
  if (!player_) co_return;
  player_->stop();
  co_await player_->ended();
}

void FaultDrill::detach() {
  happened_ = happened();
  player_.reset();
}

std::int64_t FaultDrill::happened() const {
  if (!player_) return happened_;
  const auto counts = player_->happened();
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

}  // namespace lcrig
