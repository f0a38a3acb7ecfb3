// SPDX-License-Identifier: Apache-2.0
#include "drivers/wire_log.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <stdexcept>

#include "drivers/memory_pipe.hpp"
#include "drivers/recording_transport.hpp"
#include "tests/support/replay_transport.hpp"
#include "tests/support/run_task.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

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
  const TempDir dir;
  const std::string file = dir.file("lcr.wire");
  {
    WireLogWriter writer;
    auto pair = make_memory_pipe(io.get_executor(), clock, "test");
    RecordingTransport recording(
        std::move(pair.near),
        std::make_shared<WireRecord>(writer.create(file, "lcr"), clock, WireLogHeader()));
    ASSERT_TRUE(run_task(io, clock, pair.far->write_all("+1\r\n", clock.now() + 1s)));
    EXPECT_EQ(*run_task(io, clock, ask(recording, clock, "FETC?\n")), "+1\r\n");
  }
  auto log = load_wire_log(file);
  ASSERT_TRUE(log) << log.error().what;
  ReplayTransport replay(std::move(*log), clock, "replay");
  EXPECT_EQ(*run_task(io, clock, ask(replay, clock, "FETC?\n")), "+1\r\n");
  EXPECT_TRUE(replay.at_end());
  const auto after = run_task(io, clock, ask(replay, clock, "FETC?\n"));
  ASSERT_FALSE(after);
  EXPECT_EQ(after.error().code, Errc::disconnected);
}

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(WireRecord, TransportsThatShareOneArePlayedOneAfterTheOther) {
  asio::io_context io;
  VirtualClock clock;
  const TempDir dir;
  const std::string file = dir.file("lcr.wire");
  {
    WireLogWriter writer;
    const auto log =
        std::make_shared<WireRecord>(writer.create(file, "lcr"), clock, WireLogHeader());
    for (int look = 0; look < 3; ++look) {
      auto pair = make_memory_pipe(io.get_executor(), clock, "test");
      RecordingTransport recording(std::move(pair.near), log);
      ASSERT_TRUE(run_task(io, clock, pair.far->write_all("ME\r\n", clock.now() + 1s)));
      ASSERT_TRUE(run_task(io, clock, ask(recording, clock, "*IDN?\n")));
    }
  }
  auto log = load_wire_log(file);
  ASSERT_TRUE(log) << log.error().what;
  EXPECT_EQ(log->entries.size(), 6U);
  ReplayTransport replay(std::move(*log), clock, "replay");
  for (int look = 0; look < 3; ++look) {
    EXPECT_EQ(*run_task(io, clock, ask(replay, clock, "*IDN?\n")), "ME\r\n");
  }
  EXPECT_TRUE(replay.at_end());
}

TEST(WireRecord, OneThatIsFullSaysSoAndTakesNothingMore) {
  VirtualClock clock;
  const TempDir dir;
  const std::string file = dir.file("full.wire");
  {
    WireLogWriter writer;
    WireRecord log(writer.create(file, "lcr"), clock, WireLogHeader(), 1000);
    for (int i = 0; i < 1000; ++i) log.note(true, "FETC?\n");
  }
  const std::string text = text_of(file);
  EXPECT_LT(text.size(), 1100U);
  EXPECT_TRUE(text.ends_with("# the log is full: what follows is left out\n")) << text;
  EXPECT_GT(load_wire_log(file).value().entries.size(), 20U);
}

TEST(WireLogWriter, OverwritesNothingAndFollowsNoLink) {
  const TempDir dir;
  std::ofstream(dir.file("there.wire")) << "precious";
  std::filesystem::create_symlink(dir.file("elsewhere"), dir.file("link.wire"));
  {
    WireLogWriter writer;
    writer.create(dir.file("there.wire"), "lcr")->add("new\n");
    writer.create(dir.file("link.wire"), "lcr")->add("new\n");
    writer.create(dir.file("none/a.wire"), "lcr")->add("new\n");
    writer.create(dir.file("good.wire"), "lcr")->add("new\n");
    EXPECT_TRUE(writer.finish(20s));
  }
  EXPECT_EQ(text_of(dir.file("there.wire")), "precious");
  EXPECT_FALSE(std::filesystem::exists(dir.file("elsewhere")));
  EXPECT_EQ(text_of(dir.file("good.wire")), "new\n");
}

// A pipe that nobody reads at present stands for a disk that does not answer.
class HangingDisk {
 public:
  HangingDisk() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
    read_end_ = ends[0];
    write_end_ = ends[1];
    ::fcntl(write_end_, F_SETPIPE_SZ, 4096);
  }
  ~HangingDisk() { ::close(read_end_); }
  HangingDisk(const HangingDisk&) = delete;
  HangingDisk& operator=(const HangingDisk&) = delete;
  static int create(const std::string&) { return write_end_; }
  // Everything that was written until the log was closed.
  std::string read_all() const {
    std::string out;
    char buffer[4096];
    for (ssize_t n = 0; (n = ::read(read_end_, buffer, sizeof buffer)) > 0;) {
      out.append(buffer, static_cast<std::size_t>(n));
    }
    return out;
  }

 private:
  int read_end_ = -1;
  static inline int write_end_ = -1;  // closed by the log
};

TEST(WireLogWriter, WhyNothingIsWrittenIsToldOnceForEachRun) {
  std::ostringstream journal;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(journal)));
  static int error = ENOENT;
  const auto create = [](const std::string&) {
    errno = error;
    return -1;
  };
  const auto warnings = [&journal] {
    const std::string text = journal.str();
    journal.str("");
    return std::pair(std::ranges::count(text, '\n'), text);
  };
  {
    WireLogWriter writer(WireLogWriter::Options{.create = create});
    const auto open_ports = [&writer] {
      for (int i = 0; i < 3; ++i) {
        writer.create("/nowhere/lcr.wire", "lcr")->add("text");
        writer.create("/nowhere/frame.wire", "frame")->add("text");
      }
      writer.finish(20s);
    };
    open_ports();
    const auto [lines, text] = warnings();
    EXPECT_EQ(lines, 2) << text;
    EXPECT_THAT(text, AllOf(HasSubstr("/nowhere/lcr.wire: "), HasSubstr("frame goes on without"),
                            HasSubstr("(No such file or directory)"), HasSubstr("make the folder"),
                            HasSubstr("wire_log_directory")));
    open_ports();
    EXPECT_EQ(warnings().first, 0);
    writer.remind();
    open_ports();
    EXPECT_EQ(warnings().first, 2);
    error = EACCES;
    open_ports();
    EXPECT_THAT(warnings().second, HasSubstr("(Permission denied)"));
  }
  spdlog::set_default_logger(before);
}

TEST(WireLogWriter, ADiskThatHangsHoldsNobodyUpAndWhatIsMissingIsCounted) {
  constexpr int kEntries = 1000;
  const HangingDisk disk;
  asio::io_context io;
  VirtualClock clock;
  auto pair = make_memory_pipe(io.get_executor(), clock, "test");
  WireLogWriter writer(
      WireLogWriter::Options{.max_waiting_bytes = 20'000, .create = HangingDisk::create});
  auto recording = std::make_unique<RecordingTransport>(
      std::move(pair.near),
      std::make_shared<WireRecord>(writer.create("hangs.wire", "lcr"), clock, WireLogHeader()));
  for (int i = 0; i < kEntries; ++i) {  // if this thread waited for the disk, it would never end
    ASSERT_TRUE(run_task(io, clock, pair.far->write_all("+1\r\n", clock.now() + 1s)));
    ASSERT_TRUE(run_task(io, clock, ask(*recording, clock, std::string(60, 'x'))));
  }
  EXPECT_FALSE(writer.finish(1ms)) << "the disk takes nothing";
  recording->close();
  const std::string text = disk.read_all();
  EXPECT_TRUE(writer.finish(20s));
  const auto log = parse_wire_log(text, "hangs.wire");
  ASSERT_TRUE(log) << log.error().what;
  std::size_t missing = 0;
  for (auto at = text.find("\n# "); at != text.npos; at = text.find("\n# ", at + 1)) {
    missing += std::stoul(text.substr(at + 3));
  }
  EXPECT_GT(missing, 0U);
  EXPECT_EQ(log->entries.size() + missing, 2U * kEntries);
}

TEST(WireLogWriter, ADiskThatNeverAnswersDelaysTheEndNoLongerThanItsPatience) {
  const auto disk = std::make_unique<HangingDisk>();
  const RealClock clock;
  MonoTime begin;
  {
    WireLogWriter writer(WireLogWriter::Options{.create = HangingDisk::create});
    writer.create("hangs.wire", "lcr")->add(std::string(100'000, '#'));
    begin = clock.now();
  }
  EXPECT_LT(clock.now() - begin, 20s);
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
