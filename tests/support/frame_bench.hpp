// SPDX-License-Identifier: Apache-2.0
// A ZwickLink and a ZwickSim joined by a wire in memory, in virtual time, with a listener that
// records. For tests of load frames.
#pragma once

#include <array>
#include <boost/asio/co_spawn.hpp>
#include <memory>
#include <string>
#include <vector>

#include "drivers/memory_pipe.hpp"
#include "drivers/zwick/driver.hpp"
#include "drivers/zwick/sim.hpp"
#include "tests/support/linear_scene.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {

struct MemoryListener final : LoadFrame::Listener {
  void on_samples(std::span<const FrameSample> s) override {
    samples.insert(samples.end(), s.begin(), s.end());
    ++batches;
  }
  void on_frame_event(EventName kind, std::string detail) override {
    events.push_back(kind.word() + ": " + detail);
  }
  void on_frame_lost(Error error) override { lost.push_back(std::move(error)); }
  bool has_event(std::string_view kind) const {
    return std::ranges::any_of(events, [&](const auto& e) { return e.starts_with(kind); });
  }
  std::vector<FrameSample> samples;
  std::size_t batches = 0;
  std::vector<std::string> events;
  std::vector<Error> lost;
};

inline FrameLimits wide_limits() {
  FrameLimits l;
  l.force_min = Force::from_si(-1);
  l.force_max = Force::from_si(10);
  l.travel_min = Length::from_si(-5e-3);
  l.travel_max = Length::from_si(5e-3);
  l.speed_max = Velocity::from_si(5e-3);
  return l;
}

// A task that runs beside the test body. The test need not wait for its end.
template <class T>
struct Running {
  bool done() const { return out.done; }
  support::Outcome<T> out;
};

struct FrameBench {
  explicit FrameBench(ZwickSimSettings settings = ZwickSimSettings()) {
    auto ends = pair();
    sim = std::make_unique<ZwickSim>(std::move(ends.far), clock, scene, std::move(settings));
    finish_set_up(std::move(ends.near));
  }
  explicit FrameBench(const PlantConfig& config) : scene(10'000, config) {
    auto ends = pair();
    sim = std::make_unique<ZwickSim>(std::move(ends.far), clock, scene);
    finish_set_up(std::move(ends.near));
  }
  explicit FrameBench(std::vector<RecordedRow> rows) {
    auto ends = pair();
    sim = std::make_unique<ZwickSim>(std::move(ends.far), clock, std::move(rows));
    finish_set_up(std::move(ends.near));
  }
  ~FrameBench() {
    frame.reset();
    sim->close();
    settle();
  }

  template <class T>
  T run(Task<T> task) {
    return run_task(io, clock, std::move(task));
  }
  template <class T>
  std::shared_ptr<Running<T>> begin(Task<T> task) {
    auto running = std::make_shared<Running<T>>();
    asio::co_spawn(io, std::move(task), [running](std::exception_ptr error, T value) {
      running->out.error = error;
      if (!error) running->out.value.emplace(std::move(value));
      running->out.done = true;
    });
    settle();
    return running;
  }
  template <class T>
  T await(Running<T>& running) {
    clock.run(io, [&] { return running.done(); });
    return support::take(running.out);
  }
  void settle() {
    for (io.restart(); io.poll() > 0; io.restart()) {
    }
  }
  void pass(Duration d) { clock.run_for(io, d); }
  void armed() {
    if (!run(frame->identify()) || !run(frame->arm(wide_limits()))) {
      throw std::runtime_error("the simulated frame does not arm");
    }
  }

  VirtualClock clock;  // outlives io, because waits that io destroys deregister here
  asio::io_context io;
  LinearScene scene;
  MemoryListener listener;
  std::unique_ptr<ZwickSim> sim;
  std::unique_ptr<ZwickLink> frame;
  bool sim_ended = false;

 private:
  TransportPair pair() { return make_memory_pipe(io.get_executor(), clock, "sim:frame"); }
  void finish_set_up(std::unique_ptr<Transport> near) {
    frame = std::make_unique<ZwickLink>(std::move(near), clock, io.get_executor());
    frame->set_listener(&listener);
    asio::co_spawn(io, sim->run(), [this](std::exception_ptr error) {
      sim_ended = true;
      if (error) std::rethrow_exception(error);
    });
    settle();
  }
};

// A frame link whose far end the test plays itself.
struct MuteBench {
  MuteBench() {
    auto ends = make_memory_pipe(io.get_executor(), clock, "tcp:gateway");
    far = std::move(ends.far);
    frame = std::make_unique<ZwickLink>(std::move(ends.near), clock, io.get_executor());
  }
  std::string heard() {
    std::array<char, 4096> buffer{};
    auto n =
        run_task(io, clock, far->read_some(buffer, clock.now() + std::chrono::milliseconds(1)));
    return n ? std::string(buffer.data(), *n) : std::string();
  }
  VirtualClock clock;
  asio::io_context io;
  std::unique_ptr<Transport> far;
  std::unique_ptr<ZwickLink> frame;
};

}  // namespace lcrig
