// SPDX-License-Identifier: Apache-2.0
// A whole run in which the nth operation fails, for n = 0, 1, ... until a run ends before it.
// Operations are each read and write of both wires, and each write and sync of the database.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <map>

#include "tests/support/failing_transport.hpp"
#include "tests/support/fault_world.hpp"

namespace lcrig {
namespace {

constexpr std::int64_t kEach = 40;  // the first operations, which set everything up, are all tested
constexpr std::int64_t kRuns = 100;  // about this many in all

const std::string kNthProtocol = R"({ "format": "load-protocol/1", "name": "nth",
  "on_loss": "wait", "on_loss_timeout_s": 5,
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast",
      "trigger": "internal" }, "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "near", "do": "ramp", "to": { "travel_mm": 3.19 }, "speed_mm_s": 0.65, "timeout_s": 6 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.5 }, "speed_mm_s": 0.05, "timeout_s": 6 },
    { "id": "measure", "do": "measure", "count": 4, "within_s": 1 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": 0 }, "speed_mm_s": 2, "timeout_s": 6 } ] })";

// Every n at the start, then evenly spread ones (LCRIG_EACH_OPERATION=1: all of them).
std::int64_t stride(std::int64_t operations) {
  if (std::getenv("LCRIG_EACH_OPERATION") != nullptr) return 1;
  return std::max<std::int64_t>(1, (operations - kEach) / (kRuns - kEach));
}

FaultLimits limits() {
  FaultLimits l;
  l.speed_m_s = 0.05e-3;
  return l;
}

void print(const char* what, std::int64_t operations, const std::map<std::string, int>& ended) {
  int runs = 0;
  std::string words;
  for (const auto& [how, n] : ended) runs += n, words += ", " + std::to_string(n) + " " + how;
  std::printf("%s: %lld operations in a run, %d runs%s\n", what, static_cast<long long>(operations),
              runs, words.c_str());
}

TEST(NthOperation, OfTheWiresMayFailAndTheRunIsSafeAndTrue) {
  std::map<std::string, int> ended;
  std::int64_t operations = 0, step = 1;
  for (std::int64_t n = -1;; n += n < kEach ? 1 : step) {
    SCOPED_TRACE("operation " + std::to_string(n));
    NthOperation nth(n);
    FaultWorld world(kNthProtocol, "");
    world.adjust_sim = [&nth](SimRequest& sim) {
      sim.wrap = [&nth](std::unique_ptr<Transport> wire) {
        return std::make_unique<FailingTransport>(std::move(wire), nth);
      };
    };
    const auto result = world.run();
    if (n < 0) {
      ASSERT_TRUE(result && result->exit_status == ExitStatus::success) << "without any failure";
      operations = nth.begun;
      step = stride(operations);
      continue;
    }
    if (!nth.reached) {
      EXPECT_GT(n, operations / 2) << "runs without a failure have more operations";
      break;
    }
    if (!result) {  // refused before the run row: nothing was stored or moved
      EXPECT_NE(result.error().what.find("Input/output error"), std::string::npos)
          << result.error().what;
      EXPECT_EQ(world.count("SELECT COUNT(*) FROM run"), 0);
      EXPECT_EQ(world.peak_N, 0);
      ++ended["refused"];
      continue;
    }
    Invariants(world, result, limits()).expect_all();
    ++ended[std::string(to_string(result->exit_status))];
    if (HasFailure()) break;
  }
  print("wires", operations, ended);
}

void fail_each_disk_operation(FaultyDisk::Failure how, const char* what) {
  std::map<std::string, int> ended;
  std::int64_t operations = 0, step = 1;
  for (std::int64_t n = -1;; n += n < kEach ? 1 : step) {
    SCOPED_TRACE("operation " + std::to_string(n));
    FaultWorld world(kNthProtocol, "");
    FaultyDisk& disk = world.surroundings.disk();
    if (n >= 0) disk.fail_operation(n, how);
    const auto result = world.run();
    if (n < 0) {
      ASSERT_TRUE(result && result->exit_status == ExitStatus::success) << "without any failure";
      operations = disk.operations();
      step = stride(operations);
      continue;
    }
    if (!disk.has_failed()) break;
    if (!result) {  // the database could not be created, or the run row not written
      EXPECT_NE(result.error().what.find("t.db"), std::string::npos) << result.error().what;
      EXPECT_EQ(world.peak_N, 0);
      ++ended["refused"];
      continue;
    }
    Invariants(world, result, limits()).expect_all();
    ++ended[std::string(to_string(result->exit_status))];
    if (::testing::Test::HasFailure()) break;
  }
  print(what, operations, ended);
  EXPECT_GT(ended["refused"], 0);
  EXPECT_GT(ended["fail"], 0);
}

TEST(NthOperation, OfTheDiskMayFailAndTheRunIsSafeAndTrue) {
  fail_each_disk_operation(FaultyDisk::Failure::io_error, "disk, I/O error");
}

TEST(NthOperation, OfTheDiskMayFindItFull) {
  fail_each_disk_operation(FaultyDisk::Failure::full, "disk full");
}

}  // namespace
}  // namespace lcrig
