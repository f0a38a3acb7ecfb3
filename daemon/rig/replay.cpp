// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/replay.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "daemon/rig/recording.hpp"
#include "daemon/rig/simulated.hpp"
#include "storage/runs.hpp"

namespace lcrig {

namespace {

constexpr Duration kReaction = std::chrono::seconds(2);  // of the simulated person who answers

class ReplayInstruments final : public SimulatedInstruments {
 public:
  using SimulatedInstruments::SimulatedInstruments;

  Result<> build(const std::string& directory) {
    if (auto r = keep(load_recording(directory), recording_); !r) return r;
    info_.bench_name = replay_bench(directory);
    info_.bench_text = recording_.words;
    spdlog::log(recording_.not_played > 0 ? spdlog::level::warn : spdlog::level::info, "{}: {}",
                directory, recording_.words);
    info_.simulated = true;
    info_.tells_corrections = false;
    // The simulated person confirms one second after the recording ends.
    simulated_person_ =
        std::make_unique<SimOperator>(clock_, from_seconds(recording_.duration_s() + 1));
    person_ = simulated_person_.get();
    const auto never = [] { return false; };
    respondent_ = std::make_unique<SimRespondent>(clock_, kReaction, never, Answers());
    if (auto built = build_meter(); !built) return built;
    return build_frame();
  }

 private:
  Result<> build_meter() {
    auto pair = wire("replay:lcr");
    if (!pair) return fail(pair.error());
    const auto play = [this](Duration since, Duration conversion) {
      return reading_at(to_seconds(since), to_seconds(conversion));
    };
    meter_sim_ = std::make_unique<lcr6100::Lcr6100Sim>(
        std::move(pair->far), clock_, lcr6100::SimConfig(), lcr6100::Lcr6100Sim::Recording(play));
    auto meter = std::make_unique<lcr6100::Lcr6100>(std::move(pair->near), clock_);
    meter->leave_pace_unjudged();
    meter_ = std::move(meter);
    start(meter_sim_->run(), meters_);
    return {};
  }

  Result<> build_frame() {
    auto pair = wire("replay:frame");
    if (!pair) return fail(pair.error());
    std::vector<RecordedRow> rows;
    rows.reserve(recording_.samples.size());
    for (const RecordedSample& s : recording_.samples) {
      RecordedRow row;
      row.t_s = s.t_s;
      row.travel_m = s.travel_m;
      row.force_N = s.force_N;
      rows.push_back(row);
    }
    frame_sim_ = std::make_unique<ZwickSim>(std::move(pair->far), clock_, std::move(rows));
    frame_ = std::make_unique<ZwickLink>(std::move(pair->near), clock_, executor_);
    start(frame_sim_->run(), frames_);
    return {};
  }

  // The newest reading at this time, in the meter's own format. The first question starts both
  // instruments. A reader of the run places the middle of a window half a conversion before the
  // arrival, whatever the recorded window was; so a reading with a known middle arrives that much
  // after it.
  lcr6100::Lcr6100Sim::Recorded reading_at(double t_s, double conversion_s) {
    if (!playing_) frame_sim_->start_recording();
    playing_ = true;
    const double late_s = recording_.of_middle ? conversion_s / 2 : 0;
    const auto& rows = recording_.readings;
    while (next_ < rows.size() && rows[next_].t_s + late_s <= t_s) ++next_;
    lcr6100::Lcr6100Sim::Recorded out;
    out.number = next_;
    if (next_ == 0) return out;
    out.text = fmt::format("{:+.5e},{:+.5e}", rows[next_ - 1].primary, rows[next_ - 1].secondary);
    return out;
  }

  Recording recording_;
  std::size_t next_ = 0;  // first reading that is not due yet
  bool playing_ = false;
};

}  // namespace

Result<std::unique_ptr<Instruments>> make_replay_instruments(asio::any_io_executor executor,
                                                             Clock& clock,
                                                             const std::string& directory) {
  auto replay = std::make_unique<ReplayInstruments>(executor, clock);
  if (auto built = replay->build(directory); !built) return fail(built.error());
  return std::unique_ptr<Instruments>(std::move(replay));
}

}  // namespace lcrig
