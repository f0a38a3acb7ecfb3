// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/codec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace lcrig::frame_link {
namespace {

using testing::HasSubstr;

Line must_parse(std::string_view text) {
  auto line = parse_line(text);
  EXPECT_TRUE(line) << (line ? "" : line.error().what);
  return line ? *line : Line();
}

std::string_view chomp(const std::string& line) {
  EXPECT_TRUE(line.ends_with('\n'));
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  return std::string_view(line).substr(0, line.size() - 1);
}

FrameSample sample(std::int64_t seq, double t, std::optional<double> force, double travel) {
  FrameSample s;
  s.device_seq = seq;
  s.device_time_s = t;
  s.force_N = force;
  s.travel_m = travel;
  return s;
}

// Each field is compared with all others, so a line of 64 kB could otherwise cost seconds.
TEST(FrameLinkLine, HasAHundredFieldsAtMost) {
  std::string text = "S";
  for (int i = 0; i < 100; ++i) text += " k" + std::to_string(i) + "=1";
  EXPECT_TRUE(parse_line(text));
  const auto refused = parse_line(text + " more=1");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::garbled);
}

TEST(FrameLinkLine, TakesWordNumberAndFieldsInAnyOrder) {
  const auto line = must_parse("ERR  #17 text=\"not \\\"now\\\" a\\\\b\" code=busy");
  EXPECT_EQ(line.word, "ERR");
  EXPECT_EQ(line.number, 17);
  EXPECT_EQ(line.text("code"), "busy");
  EXPECT_EQ(line.text("text"), "not \"now\" a\\b");
  const auto command = must_parse("#18 MOVE travel_mm=+1.5 speed_mm_s=2e-1 colour=green");
  EXPECT_EQ(command.word, "MOVE");
  EXPECT_EQ(command.number, 18);
  EXPECT_DOUBLE_EQ(length_of(command, "travel_mm")->si(), 1.5e-3);
  EXPECT_DOUBLE_EQ(speed_of(command)->si(), 2e-4);
}

TEST(FrameLinkLine, RefusesWhatCannotBeRead) {
  for (const char* text : {"", "   ", "MOVE travel_mm", "MOVE =1", "MOVE a=1 a=2", "#x MOVE",
                           "#-1 MOVE", "#1 OK #2", "#99999999999999999999 MOVE",
                           "EVENT text=\"open", "EVENT text=\"a\\", "HB\x01", "S\tn=1"}) {
    const auto line = parse_line(text);
    ASSERT_FALSE(line) << text;
    EXPECT_EQ(line.error().code, Errc::garbled);
  }
}

TEST(FrameLinkLine, RefusesAKeyThatWasHitOnTheLine) {
  EXPECT_TRUE(parse_line("S seq=1 n=1 force_N=0.5"));
  EXPECT_FALSE(parse_line("S seq=1 n=1 f\xefrce_N=0.5")) << "its force would be missing";
}

TEST(FrameLinkLine, OnlyFiniteDecimalNumbersAreNumbers) {
  for (const char* text :
       {"nan", "inf", "-inf", "1e999", "1,5", "0x10", "1.5mm", "", "--1", "+-1"}) {
    const auto source = std::string("X v=") + text;
    const auto line = must_parse(source);
    const auto v = line.number_of("v");
    ASSERT_FALSE(v) << text;
    EXPECT_EQ(v.error().code, Errc::garbled);
    EXPECT_FALSE(line.optional_number("v"));
  }
  const auto line = must_parse("X w=1");
  EXPECT_FALSE(line.number_of("v"));
  ASSERT_TRUE(line.optional_number("v"));
  EXPECT_FALSE(line.optional_number("v")->has_value());
}

TEST(FrameLinkSplitter, JoinsPiecesAndForgivesCarriageReturns) {
  LineSplitter splitter;
  splitter.feed("HB\r\nST");
  EXPECT_EQ(splitter.next(), "HB");
  EXPECT_EQ(splitter.next(), std::nullopt);
  splitter.feed("OP\n\nX");
  EXPECT_EQ(splitter.next(), "STOP");
  EXPECT_EQ(splitter.next(), "");
  EXPECT_EQ(splitter.next(), std::nullopt);
}

TEST(FrameLinkSplitter, DropsAnEndlessLineAndGoesOnAfterIt) {
  LineSplitter splitter;
  const std::string megabyte(1 << 20, 'x');
  for (int i = 0; i < 10; ++i) {
    splitter.feed(megabyte);
    EXPECT_EQ(splitter.next(), std::nullopt);
  }
  splitter.feed("tail\nSTOP\n");
  EXPECT_EQ(splitter.next(), "STOP");
  EXPECT_EQ(splitter.dropped(), 1U);
  splitter.feed(std::string(kMaxLine, 'y') + "\nHB\n");
  EXPECT_EQ(splitter.next(), "HB");
  EXPECT_EQ(splitter.dropped(), 2U);
}

TEST(FrameLinkMessages, CapabilitiesSurviveTheWire) {
  FrameCapabilities c;
  c.motion = c.device_stop = c.force_channel = c.zero_force = true;
  c.travel_channel = false;
  c.force_max = 20.0_N;
  c.speed_min = 0.0001_mm_s;
  c.speed_max = 10.0_mm_s;
  c.travel_min = Length::from_si(-0.1);
  c.travel_max = Length::from_si(0.1234);
  c.sample_rate_max_Hz = 500;
  c.reaction = std::chrono::milliseconds(1);
  c.deceleration = 0.05_m_s2;
  const auto text = format_caps(c);
  const auto back = parse_caps(must_parse(chomp(text)));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_TRUE(back->motion && back->device_stop && back->force_channel && back->zero_force);
  EXPECT_FALSE(back->force_hold || back->travel_channel || back->zero_travel);
  EXPECT_EQ(back->force_max, c.force_max);
  EXPECT_DOUBLE_EQ(back->speed_min.si(), 1e-7);
  EXPECT_DOUBLE_EQ(back->travel_max.si(), c.travel_max.si());
  EXPECT_EQ(back->reaction, c.reaction);
  EXPECT_EQ(back->deceleration, c.deceleration);
}

TEST(FrameLinkMessages, CapabilitiesWithoutAFieldOrWithAnEmptyRangeAreGarbled) {
  FrameCapabilities c;
  c.force_max = 20.0_N;
  c.speed_max = 1.0_mm_s;
  c.sample_rate_max_Hz = 10;
  c.deceleration = 0.05_m_s2;
  auto text = format_caps(c);
  ASSERT_TRUE(parse_caps(must_parse(chomp(text))));
  EXPECT_FALSE(parse_caps(must_parse("CAPS motion=1")));
  c.force_class = ForceClass(3);
  auto of_class = format_caps(c);
  EXPECT_EQ(parse_caps(must_parse(chomp(of_class)))->force_class, ForceClass(3));
  EXPECT_EQ(parse_caps(must_parse(chomp(text)))->force_class, std::nullopt);
  of_class.replace(of_class.find("force_class=3"), 13, "force_class=7");
  EXPECT_FALSE(parse_caps(must_parse(chomp(of_class)))) << "there is no class 7";
  text.replace(text.find("rate_max_hz=10"), 14, "rate_max_hz=-1");
  EXPECT_FALSE(parse_caps(must_parse(chomp(text))));
}

TEST(FrameLinkMessages, StatedStepsFilterAndPlaySurviveTheWireAndMayBeAbsent) {
  FrameCapabilities c;
  c.force_max = 20.0_N;
  c.speed_max = 1.0_mm_s;
  c.sample_rate_max_Hz = 10;
  c.deceleration = 0.05_m_s2;
  const auto silent = parse_caps(must_parse(chomp(format_caps(c))));
  EXPECT_FALSE(silent->travel_step || silent->force_step || silent->filter || silent->play);
  c.travel_step = Length::from_si(0.25e-6);
  c.force_step = Force::from_si(0.5e-3);
  c.filter = std::chrono::milliseconds(20);
  c.play = Length();
  auto text = format_caps(c);
  EXPECT_THAT(text, HasSubstr(" travel_step_um=0.25 force_step_mN=0.5 filter_s=0.02 play_um=0"));
  const auto back = parse_caps(must_parse(chomp(text)));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(*back, c);
  text.replace(text.find("play_um=0"), 9, "play_um=-1");
  EXPECT_FALSE(parse_caps(must_parse(chomp(text))));
}

TEST(FrameLinkMessages, CommandsReadAsTheSpecificationSays) {
  EXPECT_EQ(format_move(17, 2.5_mm, 0.5_mm_s), "#17 MOVE travel_mm=2.5 speed_mm_s=0.5\n");
  EXPECT_EQ(format_move_until(18, 1.0_N, 0.016_mm_s, 3.0_mm),
            "#18 MOVEF force_N=1 speed_mm_s=0.016 guard_mm=3\n");
  EXPECT_EQ(format_ramp(19, 0.5_N, 0.1_N_s), "#19 RAMPF force_N=0.5 rate_N_s=0.1\n");
  EXPECT_EQ(format_hold_travel(20), "#20 HOLD mode=travel\n");
  EXPECT_EQ(format_hold_force(21, 1.0_N), "#21 HOLD mode=force force_N=1\n");
  EXPECT_EQ(format_zero(22, true, false), "#22 ZERO force=1 travel=0\n");
  EXPECT_EQ(format_rate(23, 50), "#23 RATE hz=50\n");
  FrameLimits l;
  l.force_min = -0.2_N;
  l.force_max = 1.5_N;
  l.travel_min = -5.0_mm;
  l.travel_max = 1.0_mm;
  l.speed_max = 1.0_mm_s;
  EXPECT_EQ(format_limits(3, l),
            "#3 LIMITS force_min_N=-0.2 force_max_N=1.5 travel_min_mm=-5 travel_max_mm=1 "
            "speed_max_mm_s=1\n");
}

TEST(FrameLinkMessages, TextCannotBreakTheLine) {
  const auto text = format_err(5, "busy", "two\nlines \"quoted\" #7 a=b \\");
  const auto line = must_parse(chomp(text));
  EXPECT_EQ(line.number, 5);
  EXPECT_EQ(line.text("text"), "two lines \"quoted\" #7 a=b \\");
}

TEST(FrameLinkMessages, AnUnknownReasonIsAFaultAndNeverATarget) {
  MotionOutcome o;
  o.reason = MotionEnd::travel_limit;
  o.travel_m = 2.6134e-3;
  const auto text = format_done(5, o);
  const auto back = parse_done(must_parse(chomp(text)));
  EXPECT_EQ(back.reason, MotionEnd::travel_limit);
  EXPECT_EQ(back.travel_m, 2.6134e-3);
  EXPECT_FALSE(back.force_N);
  const auto odd = parse_done(must_parse("DONE #5 reason=bored"));
  EXPECT_EQ(odd.reason, MotionEnd::fault);
  EXPECT_THAT(odd.detail, HasSubstr("bored"));
  EXPECT_EQ(parse_done(must_parse("DONE #5")).reason, MotionEnd::fault);
}

TEST(FrameLinkSamples, BatchesSurviveTheWireWithHolesAndFlags) {
  std::vector<FrameSample> batch{sample(101, 4.02, 0.1213, 2.5003e-3),
                                 sample(102, 4.04, std::nullopt, 2.5006e-3)};
  batch[0].flags = frame_flag::kMoving;
  batch[1].flags = frame_flag::kMoving | frame_flag::kForceOverload;
  std::string text;
  append_samples(text, batch);
  EXPECT_EQ(text,
            "S seq=101 n=2 t_s=4.02,4.04 force_N=0.1213, travel_mm=2.5003,2.5006 flags=M,MO\n");
  std::vector<FrameSample> back;
  ASSERT_TRUE(parse_samples(must_parse(chomp(text)), back));
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0].device_seq, 101);
  EXPECT_EQ(back[1].device_seq, 102);
  EXPECT_EQ(back[0].force_N, 0.1213);
  EXPECT_FALSE(back[1].force_N);
  EXPECT_EQ(back[1].travel_m, 2.5006e-3);
  EXPECT_EQ(back[1].flags, batch[1].flags);
}

TEST(FrameLinkSamples, AnAbsentColumnIsAnAbsentValue) {
  std::vector<FrameSample> back;
  ASSERT_TRUE(parse_samples(must_parse("S seq=1 n=2 force_N=1,2 flags=M"), back));
  EXPECT_FALSE(back[0].travel_m || back[0].device_time_s);
  EXPECT_EQ(back[1].flags, frame_flag::kMoving);
}

TEST(FrameLinkSamples, ABrokenBatchLeavesNothingBehind) {
  std::vector<FrameSample> out(1);
  for (const char* text :
       {"S n=1", "S seq=1", "S seq=1 n=0", "S seq=1 n=99999999", "S seq=-1 n=1",
        "S seq=9223372036854775807 n=2", "S seq=1 n=2 force_N=1", "S seq=1 n=2 force_N=1,2,3",
        "S seq=1 n=2 force_N=1,nan", "S seq=1 n=3 flags=M,M", "S seq=1.5 n=1"}) {
    const auto r = parse_samples(must_parse(text), out);
    ASSERT_FALSE(r) << text;
    EXPECT_EQ(r.error().code, Errc::garbled);
    EXPECT_EQ(out.size(), 1U);
  }
}

TEST(FrameLinkSamples, DecimalMillimetresComeBackDigitForDigit) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> micro(-9'000'000, 9'000'000);
  for (int i = 0; i < 2000; ++i) {
    const double mm = micro(random) / 1e5;
    std::string text;
    append_samples(text, std::vector{sample(1, 0.0, 0.0, mm / 1e3)});
    const auto line = must_parse(chomp(text));
    ASSERT_EQ(line.number_of("travel_mm").value(), mm);
  }
}

TEST(FrameLinkLine, NoBytesOfAnyKindBreakTheReader) {
  std::mt19937 random(11);
  const std::string letters = "#17 MOVES=,.+-e\"\\\n\r nxseqt_Nlag\x00\xff";
  std::uniform_int_distribution<std::size_t> pick(0, letters.size() - 1);
  LineSplitter splitter;
  std::vector<FrameSample> out;
  std::size_t lines = 0;
  for (int i = 0; i < 200'000; ++i) {
    splitter.feed(std::string_view(&letters[pick(random)], 1));
    while (const auto text = splitter.next()) {
      ++lines;
      const auto line = parse_line(*text);
      if (!line) continue;
      static_cast<void>(parse_samples(*line, out));
      static_cast<void>(parse_caps(*line));
      static_cast<void>(parse_limits(*line));
      static_cast<void>(parse_hello(*line));
      static_cast<void>(parse_done(*line));
    }
  }
  EXPECT_GT(lines, 1000U);
}

}  // namespace
}  // namespace lcrig::frame_link
