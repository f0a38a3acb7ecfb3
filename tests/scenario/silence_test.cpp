// SPDX-License-Identifier: Apache-2.0
// Instruments that are present but do not answer, and links that stay dead, in virtual time.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"
#include "tests/support/loss_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// Counts log lines by minute of virtual time during its lifetime.
class LineCount {
 public:
  explicit LineCount(const VirtualClock& clock)
      : sink_(std::make_shared<Sink>(clock)), previous_(spdlog::default_logger()) {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("count", sink_));
  }
  ~LineCount() { spdlog::set_default_logger(previous_); }
  LineCount(const LineCount&) = delete;
  LineCount& operator=(const LineCount&) = delete;
  int total() const {
    int n = 0;
    for (const auto& [minute, lines] : sink_->lines) n += lines;
    return n;
  }
  const std::string& text() const { return sink_->text; }
  int worst() const {
    int n = 0;
    for (const auto& [minute, lines] : sink_->lines) n = std::max(n, lines);
    return n;
  }

 private:
  struct Sink final : spdlog::sinks::base_sink<std::mutex> {
    explicit Sink(const VirtualClock& c) : clock(c) {}
    void sink_it_(const spdlog::details::log_msg& m) override {
      ++lines[clock.now().time_since_epoch() / 60s];
      text += fmt::format("{:.1f} s: {}\n", to_seconds(clock.now().time_since_epoch()),
                          std::string_view(m.payload.data(), m.payload.size()));
    }
    void flush_() override {}
    const VirtualClock& clock;
    std::map<std::int64_t, int> lines;
    std::string text;
  };
  std::shared_ptr<Sink> sink_;
  std::shared_ptr<spdlog::logger> previous_;
};

TEST(Reconnect, TenDeadMinutesDoNotFloodLogOrDatabase) {
  for (const bool silent : {false, true}) {
    SCOPED_TRACE(silent ? "silent" : "unplugged");
    SessionWorld world(
        loss_protocol("wait", R"({ "id": "record", "do": "record", "for_s": 700 })", "650"));
    const auto set = [silent](SessionWorld& w, bool dead) {
      if (silent) {
        w.session->instruments().door()->meter_sim().faults().silent = dead;
      } else {
        dead ? unplug(w, Which::meter) : plug(w, Which::meter);
      }
    };
    world.acts.push_back({"record", 2s, [&](SessionWorld& w) { set(w, true); }});
    world.acts.push_back({"record", 602s, [&](SessionWorld& w) { set(w, false); }});
    const LineCount lines(world.clock);
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
    EXPECT_GT(lines.total(), 2) << lines.text();
    EXPECT_LE(lines.worst(), 10);
    // A read-back every 3 s is planned, whether the other instrument answers or not.
    EXPECT_LE(world.count("SELECT COUNT(*) FROM event WHERE kind <> 'read_back'"), 40);
    std::printf("dead line for 10 minutes: %d log lines, at most %d a minute\n", lines.total(),
                lines.worst());
  }
}

TEST(Reconnect, ASilentInstrumentIsALostOne) {
  for (const Which which : {Which::meter, Which::frame}) {
    SessionWorld world(loss_protocol("wait", kEveryKind));
    const auto set = [which](SessionWorld& w, bool silent) {
      BenchDoor& door = *w.session->instruments().door();
      if (which == Which::meter) {
        door.meter_sim().faults().silent = silent;
      } else {
        door.frame_sim()->faults.silent = silent;
        door.frame_sim()->poke();
      }
    };
    world.acts.push_back({"settle", 300ms, [&](SessionWorld& w) { set(w, true); }});
    world.acts.push_back({"settle", 20300ms, [&](SessionWorld& w) { set(w, false); }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
    EXPECT_EQ(events(world, "loss"), 1);
    EXPECT_EQ(events(world, "reconnected"), 1);
    expect_invariants(world);
  }
}

}  // namespace
}  // namespace lcrig
