// SPDX-License-Identifier: Apache-2.0
#include "drivers/wire_log.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <cstdio>
#include <random>

#include "drivers/memory_pipe.hpp"
#include "drivers/recording_transport.hpp"
#include "tests/support/replay_transport.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kSmall =
    "wire-log/1\n"
    "instrument: LCR-6100\nfirmware: REV E8.13\ndate: 2026-01-01\nconditions: bench\n"
    "\n# a remark\n"
    "0 > \"*IDN?\\n\"\n"
    "1500 < \"LCR-6100,\\\"x\\\",\\\\\\r\\n\"\n";

TEST(WireLog, ReadsHeaderAndEntries) {
  const auto log = parse_wire_log(kSmall, "small.wire");
  ASSERT_TRUE(log) << log.error().what;
  EXPECT_EQ(log->header.firmware, "REV E8.13");
  ASSERT_EQ(log->entries.size(), 2U);
  EXPECT_TRUE(log->entries[0].to_instrument);
  EXPECT_EQ(log->entries[0].line, 8);
  EXPECT_EQ(log->entries[1].t_ns, 1500);
  EXPECT_EQ(log->entries[1].bytes, "LCR-6100,\"x\",\\\r\n");
}

TEST(WireLog, EveryByteSurvivesWritingAndReading) {
  std::string all;
  for (int c = 0; c < 256; ++c) all += static_cast<char>(c);
  const std::string text = format_wire_header({}) + format_wire_entry(7, false, all);
  const auto log = parse_wire_log(text, "all.wire");
  ASSERT_TRUE(log) << log.error().what;
  EXPECT_EQ(log->entries.at(0).bytes, all);
}

TEST(WireLog, RefusesHostileTextWithItsLine) {
  const std::string head = "wire-log/1\n";
  for (const std::string line :
       {"0 > \"abc", "0 > abc", "0 > \"a\\\"", "0 > \"\\x4\"", "0 > \"\\xzz\"", "0 > \"\\q\"",
        "0 > \"a\"b\"", "0 > \"a\" x", "0 = \"a\"", "0 \"a\"", "99999999999999999999 > \"a\"",
        "-1 > \"a\"", "unknown: x", "0 > \"a\x01\"", "0", "0 > \""}) {
    const auto r = parse_wire_log(head + line, "bad.wire");
    ASSERT_FALSE(r) << line;
    EXPECT_EQ(r.error().code, Errc::invalid_request);
    EXPECT_NE(r.error().what.find("bad.wire:2: expected"), std::string::npos) << r.error().what;
  }
  EXPECT_FALSE(parse_wire_log("", "empty.wire"));
  EXPECT_FALSE(parse_wire_log("0 > \"a\"\n", "headless.wire"));
  EXPECT_FALSE(parse_wire_log(head + "5 > \"a\"\n4 > \"a\"\n", "backwards.wire"));
  EXPECT_FALSE(parse_wire_log(head + "5 > \"a\"\ndate: late\n", "late.wire"));
}

TEST(WireLog, RandomDamageNeverCrashesTheReader) {
  std::mt19937 random(7);
  for (int round = 0; round < 20000; ++round) {
    std::string text(kSmall);
    for (int hit = 0; hit < 3; ++hit) {
      text[random() % text.size()] = static_cast<char>(random() % 256);
    }
    text.resize(random() % (text.size() + 1));
    const auto log = parse_wire_log(text, "damaged.wire");
    EXPECT_TRUE(!log || log->entries.size() <= 2U);
  }
}

struct TempFile {
  TempFile() {
    const int fd = ::mkstemp(path.data());
    if (fd >= 0) ::close(fd);
  }
  ~TempFile() { std::remove(path.c_str()); }
  std::string path = "/tmp/lcrig-wire-XXXXXX";
};

Task<Result<std::string>> ask(Transport& t, Clock& clock, std::string what) {
  auto written = co_await t.write_all(what, clock.now() + 1s);
  if (!written) co_return fail(written.error());
  std::string buffer(64, '\0');
  auto n = co_await t.read_some(buffer, clock.now() + 1s);
  if (!n) co_return fail(n.error());
  buffer.resize(*n);
  co_return buffer;
}

TEST(RecordingTransport, WhatItRecordsTheReplayPlays) {
  asio::io_context io;
  VirtualClock clock;
  TempFile file;
  {
    auto pair = make_memory_pipe(io.get_executor(), clock, "test");
    auto recording = make_recording(std::move(pair.near), clock, file.path, WireLogHeader());
    ASSERT_TRUE(recording);
    ASSERT_TRUE(run_task(io, clock, pair.far->write_all("+1\r\n", clock.now() + 1s)));
    EXPECT_EQ(*run_task(io, clock, ask(**recording, clock, "FETC?\n")), "+1\r\n");
  }
  auto log = load_wire_log(file.path);
  ASSERT_TRUE(log) << log.error().what;
  ReplayTransport replay(std::move(*log), clock, "replay");
  EXPECT_EQ(*run_task(io, clock, ask(replay, clock, "FETC?\n")), "+1\r\n");
  EXPECT_TRUE(replay.at_end());
  const auto after = run_task(io, clock, ask(replay, clock, "FETC?\n"));
  ASSERT_FALSE(after);
  EXPECT_EQ(after.error().code, Errc::disconnected);
}

TEST(ReplayTransport, AMismatchNamesLineAndBothTexts) {
  asio::io_context io;
  VirtualClock clock;
  ReplayTransport replay(*parse_wire_log(kSmall, "small.wire"), clock, "replay");
  const auto r = run_task(io, clock, ask(replay, clock, "*TRG\n"));
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::invalid_request);
  EXPECT_EQ(r.error().what,
            "replay: line 8 of the wire log has > \"*IDN?\\n\", but \"*TRG\\n\" was written");
}

TEST(ReplayTransport, SaysNothingBeforeItIsAsked) {
  asio::io_context io;
  VirtualClock clock;
  ReplayTransport replay(*parse_wire_log(kSmall, "small.wire"), clock, "replay");
  std::string buffer(64, '\0');
  const auto n = run_task(io, clock, replay.read_some(buffer, clock.now() + 2s));
  ASSERT_FALSE(n);
  EXPECT_EQ(n.error().code, Errc::no_reply);
  EXPECT_EQ(clock.now().time_since_epoch(), 2s);
}

}  // namespace
}  // namespace lcrig
