// SPDX-License-Identifier: Apache-2.0
// Virtual time uses wires in memory. The sockets of the kernel must carry the same.
#include <gtest/gtest.h>

#include "drivers/fd_transport.hpp"
#include "tests/support/loss_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

class WiredWorld final : public SessionWorld {
 public:
  explicit WiredWorld(MakeWire wire)
      : SessionWorld(loss_protocol("wait", kEveryKind)), wire_(std::move(wire)) {
    in_memory = true;
    away(*this, "level", Which::meter, 1s, 3s);
    away(*this, "record", Which::frame, 500ms, 2s);
  }
  // Every value of every row, one per line.
  std::string rows(const std::string& table) const {
    const Database db = open();
    auto row = db.prepare("SELECT * FROM " + table).value();
    std::string out;
    while (row.step().value()) {
      for (int i = 0; i < row.columns(); ++i) out.append(row.text(i)) += '|';
      out += '\n';
    }
    return out;
  }

 protected:
  void adjust(SimRequest& sim, Recorder::Options& /*recorder*/) override { sim.wire = wire_; }

 private:
  MakeWire wire_;
};

TEST(Wire, MemoryAndSocketsCarryTheSameRunToTheNanosecond) {
  WiredWorld memory{MakeWire()}, sockets{make_socketpair};
  for (WiredWorld* world : {&memory, &sockets}) {
    const auto r = world->run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  }
  EXPECT_EQ(memory.count("SELECT COUNT(*) FROM event WHERE kind = 'loss'"), 2);
  for (const char* table : {"lcr_reading", "frame_sample", "event", "level", "run_end"}) {
    EXPECT_EQ(memory.rows(table), sockets.rows(table)) << table;
  }
}

}  // namespace
}  // namespace lcrig
