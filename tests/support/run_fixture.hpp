// SPDX-License-Identifier: Apache-2.0
// The parts of a run over stub instruments, in virtual time; a test can drive each part alone.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <optional>

#include "protocols/file/parse.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/run_parts.hpp"
#include "tests/support/run_task.hpp"
#include "tests/support/stub_rig.hpp"

namespace lcrig {

class RunFixture : public ::testing::Test {
 protected:
  static constexpr const char* kProtocol = R"({ "format": "load-protocol/1", "name": "t",
    "limits": { "force_N": [-1, 1], "travel_mm": [0, 60] },
    "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
                         "aperture": "fast" } },
    "steps": [ { "id": "r", "do": "ramp", "to": { "travel_mm": 1 }, "speed_mm_s": 1,
                 "timeout_s": 60 },
               { "id": "s", "do": "measure", "count": 5, "within_s": 5 } ],
    "finally": [ { "id": "c", "do": "ramp", "to": { "travel_mm": 0 }, "speed_mm_s": 1,
                   "timeout_s": 60 } ] })";

  // Change it before the first use of `parts`.
  RunSetup& setup() {
    if (!setup_) {
      setup_.emplace(clock, meter, frame, sink, protocol);
      setup_->limits = bind_limits(protocol, setup_->environment, frame.capabilities()).value();
      setup_->forecast.emplace(frame.capabilities(), ForceBound({}, 120e3), std::nullopt);
    }
    return *setup_;
  }
  RunParts& parts() {
    if (!parts_) {
      Sampler::Hooks hooks;
      hooks.tag = [] { return ReadingTag(); };
      hooks.taken = [](const LcrReading&, const ReadingTag&) {};
      hooks.event = [](EventKind, const std::string&) {};
      hooks.lost = [](const Error&) {};
      hooks.read_back = [](const ReadBackEvent&) {};
      hooks.unproven = [](const UnprovenEvent&) {};
      parts_.emplace(io.get_executor(), setup(), values, [this] { ++looks; }, hooks);
      parts_->watch.set_prepared(true);
      sink.events.clear();
    }
    return *parts_;
  }
  // After another change of `setup`: the parts of a new run.
  RunParts& restart() {
    parts_.reset();
    return parts();
  }
  const Step& step(std::size_t i) const { return protocol.steps[i]; }
  template <class T>
  T run(Task<T> task) {
    return run_task(io, clock, std::move(task));
  }
  // Starts a task without a value; `ended` tells whether it has ended.
  void start(Task<> task, bool& ended) {
    asio::co_spawn(io, std::move(task), [&ended](std::exception_ptr) { ended = true; });
  }
  // From now on samples come ten times a second, and the parts of the run see them.
  void feed() {
    frame.set_listener(&feed_);
    asio::co_spawn(io, frame.send_samples(), asio::detached);
  }
  // Shows one sample to the parts of the run.
  std::vector<Finding> show(double force_N, double travel_m) {
    frame.force_N = force_N;
    frame.travel_m = travel_m;
    const FrameSample s = frame.sample();
    parts().meter.add(std::span(&s, 1));
    return parts().watch.add(s);
  }
  std::int64_t events_of(const std::string& kind) const {
    return std::ranges::count(sink.kinds(), kind);
  }

  VirtualClock clock;
  asio::io_context io;
  StubMeter meter{clock};
  StubFrame frame{clock};
  EventSink sink;
  Environment values;  // of the current step
  Protocol protocol = parse_protocol(kProtocol, "t").value();
  int looks = 0;

 private:
  struct Feed final : LoadFrame::Listener {
    explicit Feed(RunFixture& f) : fixture(f) {}
    void on_samples(std::span<const FrameSample> samples) override {
      fixture.parts().meter.add(samples);
      for (const FrameSample& s : samples) {
        fixture.parts().drive.see(s);
        fixture.parts().response.act(fixture.parts().watch.add(s));
      }
    }
    void on_frame_event(EventName, std::string) override {}
    void on_frame_lost(Error) override {}
    RunFixture& fixture;
  };

  Feed feed_{*this};
  std::optional<RunSetup> setup_;
  std::optional<RunParts> parts_;
};

}  // namespace lcrig
