// SPDX-License-Identifier: Apache-2.0
// A writer thread that gets no processor, or has a slow disk, changes nothing in virtual time: the
// same run gives the same rows in the same commits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <optional>

#include "daemon/app.hpp"
#include "daemon/session.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/faulty_disk.hpp"
#include "storage/row_hash.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr const char* kOneLevel = R"({ "format": "load-protocol/1", "name": "short",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.5, "force_N": 0.05, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "load", "do": "ramp", "to": { "force_N": 0.4 }, "force_rate_N_s": 0.5, "timeout_s": 60 },
    { "id": "level", "do": "measure", "count": 20, "within_s": 8 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 2, "timeout_s": 60 } ] })";

class DaemonWithADisk {
 public:
  explicit DaemonWithADisk(Duration per_sync) { disk_.set_sync_delay(per_sync); }

  Result<RunOutcome> run() {
    RunRequest wanted;
    wanted.protocol_name = "short";
    wanted.protocol_text = kOneLevel;
    wanted.specimen_name = "paper-1";
    wanted.specimen_text = std::string(shipped_specimens().front().text);
    auto prepared = prepare_run(std::move(wanted));
    if (!prepared) return fail(prepared.error());
    Config config;
    config.database = path_;
    config.bench = "paper";
    AppParts parts;
    parts.vfs = disk_.name();
    App app(io_, clock_, std::move(config), std::move(parts));
    if (auto opened = app.open(); !opened) return fail(opened.error());
    asio::co_spawn(io_, play(app, std::move(*prepared)), [](std::exception_ptr bug) {
      if (bug) std::rethrow_exception(bug);
    });
    clock_.run(io_, [this] { return outcome_ && clock_.pending() == 0; });
    return std::move(*outcome_);
  }
  // Every row, and how they were committed; without the hashes, because each run has its own uuid.
  std::string recorded() const {
    const auto db = open_read_only(path_).value();
    std::string all;
    for (const char* rows :
         {"SELECT * FROM level", "SELECT * FROM event", "SELECT * FROM lcr_reading",
          "SELECT * FROM frame_sample",
          "SELECT seq, level_seq, event_seq, lcr_reading_seq, frame_sample_seq FROM chain"}) {
      EXPECT_TRUE(db.each(rows, [&all](const Statement& row) {
        for (int i = 0; i < row.columns(); ++i) all.append(row.text(i)).append("|");
      }));
    }
    return sha256_hex(all);
  }

 private:
  Task<> play(App& app, PreparedRun prepared) {
    auto outcome = co_await app.run_through(std::move(prepared));
    co_await app.shut_down("over");
    outcome_.emplace(std::move(outcome));
  }

  TempDir dir_;
  std::string path_ = dir_.file("d.db");
  FaultyDisk disk_;
  VirtualClock clock_;
  asio::io_context io_{1};
  std::optional<Result<RunOutcome>> outcome_;
};

TEST(SlowDisk, ChangesNoRowAndNoCommitInVirtualTime) {
  DaemonWithADisk fast(0ms), slow(3ms);
  const auto first = fast.run(), second = slow.run();
  ASSERT_TRUE(first) << first.error().what;
  ASSERT_TRUE(second) << second.error().what;
  EXPECT_EQ(first->exit_status, ExitStatus::success) << first->reason;
  EXPECT_EQ(second->exit_status, ExitStatus::success) << second->reason;
  EXPECT_GT(first->lcr_readings, 100);
  EXPECT_EQ(slow.recorded(), fast.recorded());
}

}  // namespace
}  // namespace lcrig
