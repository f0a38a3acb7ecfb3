// SPDX-License-Identifier: Apache-2.0
// Recordings with mistakes that other programs make: each is read rightly, or refused with its file
// and line. What must come out is known from the recording before the mistake was made in it.
#include <gmock/gmock.h>

#include <functional>
#include <optional>
#include <random>

#include "daemon/rig/recording.hpp"
#include "tests/support/made_recording.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using support::MadeFile;
using support::MadeRecording;
using ::testing::HasSubstr;

// Both files as texts; nullopt: the file is missing.
struct Files {
  std::optional<std::string> lcr, frame;
};

Result<Recording> loaded(const Files& files) {
  const TempDir dir;
  if (files.lcr) support::write_text(dir.file("lcr.csv"), *files.lcr);
  if (files.frame) support::write_text(dir.file("frame.csv"), *files.frame);
  return load_recording(dir.path().string());
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (auto at = text.find(from); at != text.npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// A file with the chosen row (from 0) changed.
std::string with_row(MadeFile file, std::size_t row, const std::string& line) {
  const auto at = [&file](std::size_t i) {
    return fmt::format("{:.{}f},{}\n", file.rows[i].t_s, file.decimals, file.rows[i].others);
  };
  std::string out = file.header + "\n";
  for (std::size_t i = 0; i < file.rows.size(); ++i) out += i == row ? line : at(i);
  return out;
}

class Drawn {
 public:
  explicit Drawn(std::uint64_t seed) : random_(seed) {
    made.loadings = 1;
    made.rest_s = 1 + even();
    made.branch_s = 0.5 + even();
    made.sample_s = 0.01 + 0.03 * even();
    made.window_s = 0.04 + 0.1 * even();
    made.seed = seed;
    lcr = made.lcr();
    frame = made.frame();
  }
  double even() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  std::size_t below(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_);
  }
  MadeRecording made;
  MadeFile lcr, frame;

 private:
  std::mt19937_64 random_;
};

// Row for row what was made, with the times relative to the earlier of the two first rows.
void expect_all_rows(const Result<Recording>& got, const MadeFile& lcr, const MadeFile& frame) {
  ASSERT_TRUE(got) << got.error().what;
  const double zero_s = std::min(lcr.rows.front().t_s, frame.rows.front().t_s);
  EXPECT_NEAR(got->zero_s, zero_s, 1e-4);
  ASSERT_EQ(got->readings.size(), lcr.rows.size());
  ASSERT_EQ(got->samples.size(), frame.rows.size());
  for (std::size_t i = 0; i < lcr.rows.size(); ++i) {
    ASSERT_NEAR(got->readings[i].t_s, lcr.rows[i].t_s - zero_s, 2e-4);
    const auto value = fmt::format("{:.5e},9.1e7", got->readings[i].primary);
    ASSERT_EQ(value, lcr.rows[i].others);
  }
  for (std::size_t i = 0; i < frame.rows.size(); ++i) {
    ASSERT_NEAR(got->samples[i].t_s, frame.rows[i].t_s - zero_s, 2e-4);
    ASSERT_EQ(fmt::format("{:.4f},{:.4f}", got->samples[i].travel_m * 1e3, got->samples[i].force_N),
              frame.rows[i].others);
  }
  EXPECT_EQ(got->words.find("not played"), std::string::npos) << got->words;
}

void expect_refused(const Result<Recording>& got, const std::string& place,
                    const std::string& expected) {
  ASSERT_FALSE(got) << place << ": " << expected;
  EXPECT_THAT(got.error().what, HasSubstr(place));
  EXPECT_THAT(got.error().what, HasSubstr(expected));
}

constexpr int kDrawn = 25;  // of each mistake

void for_each_drawn(const std::function<void(Drawn&)>& check) {
  for (int seed = 1; seed <= kDrawn; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Drawn drawn(static_cast<std::uint64_t>(seed));
    check(drawn);
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(Recordings, OfAnyZeroAreReadAsTheyAre) {
  for_each_drawn([](Drawn& d) {
    const double zeros_s[] = {0, -3.25, -5000, 1.79e9 + d.even() * 1e6, 86'400 * d.even()};
    const double zero_s = zeros_s[d.below(5)];
    d.lcr.shift(zero_s);
    d.frame.shift(zero_s);
    expect_all_rows(loaded({d.lcr.text(), d.frame.text()}), d.lcr, d.frame);
  });
}

TEST(Recordings, MayHaveAMarkOtherLineEndsOtherColumnsAndPlusSigns) {
  for_each_drawn([](Drawn& d) {
    Files files{d.lcr.text(), d.frame.text()};
    for (auto* text : {&files.lcr, &files.frame}) {
      if (d.below(2) == 0) *text = replaced(**text, "\n", "\r\n");
      if (d.below(2) == 0) *text = "\xef\xbb\xbf" + **text;
      if (d.below(2) == 0) *text = replaced(**text, ",", " , ");
      if (d.below(2) == 0) **text += "\n  \n";
    }
    if (d.below(2) == 0) *files.lcr = replaced(*files.lcr, ",3.", ",+3.");
    expect_all_rows(loaded(files), d.lcr, d.frame);
  });
}

// One file is shifted against the other: the rows keep their distance, and what one file has alone
// is named.
TEST(Recordings, KeepTheDistanceOfTheirFiles) {
  for_each_drawn([](Drawn& d) {
    const double by_s = (d.even() - 0.5) * 1.6 * d.made.duration_s();
    d.frame.shift(by_s);
    const auto got = loaded({d.lcr.text(), d.frame.text()});
    ASSERT_TRUE(got) << got.error().what;
    constexpr double kAlone_s = 0.5, kRounding_s = 2e-4;
    const double from_s = d.frame.rows.front().t_s, to_s = d.frame.rows.back().t_s;
    const double lcr_from_s = d.lcr.rows.front().t_s, lcr_to_s = d.lcr.rows.back().t_s;
    std::size_t alone = 0, next = 0;
    for (const MadeFile::Row& row : d.lcr.rows) {
      if (row.t_s < from_s - kAlone_s || row.t_s > to_s + kAlone_s) {
        ++alone;
        continue;
      }
      ASSERT_LT(next, got->readings.size());
      ASSERT_NEAR(got->readings[next].t_s + got->zero_s, row.t_s, kRounding_s);
      ++next;
    }
    EXPECT_EQ(next, got->readings.size());
    std::size_t samples = 0;
    for (const MadeFile::Row& row : d.frame.rows) {
      const bool alone_here = row.t_s < lcr_from_s - kAlone_s || row.t_s > lcr_to_s + kAlone_s;
      samples += alone_here ? 1 : 0;
    }
    EXPECT_EQ(got->samples.size(), d.frame.rows.size() - samples);
    const auto said = fmt::format("{} readings, {} samples", alone, samples);
    if (alone + samples > 0) {
      EXPECT_THAT(got->words, HasSubstr(said));
    }
  });
}

TEST(Recordings, ThatDoNotOverlapAreRefused) {
  for_each_drawn([](Drawn& d) {
    const double away_s = d.made.duration_s() * (1.1 + d.even());
    const double by_s[] = {away_s, -away_s, 1.79e9};  // the last: only one of them has epoch times
    (d.below(2) == 0 ? d.lcr : d.frame).shift(by_s[d.below(3)]);
    expect_refused(loaded({d.lcr.text(), d.frame.text()}), "lcr.csv has times from",
                   "do not overlap");
  });
}

TEST(Recordings, ThatAreCutOffAnywhereAreRefusedOrWhole) {
  for_each_drawn([](Drawn& d) {
    Files files{d.lcr.text(), d.frame.text()};
    const bool lcr = d.below(2) == 0;
    std::string& text = lcr ? *files.lcr : *files.frame;
    const auto header = text.find('\n') + 1;
    // Within the last rows, so that the files overlap all the same.
    text.resize(text.size() - 1 - d.below(std::min<std::size_t>(60, text.size() - header)));
    const auto line = std::ranges::count(text, '\n') + 1;
    const auto got = loaded(files);
    if (text.ends_with('\n')) {
      ASSERT_TRUE(got) << got.error().what;  // cut between two rows: nothing tells, all are whole
      return;
    }
    expect_refused(got, fmt::format("{}:{}", lcr ? "lcr.csv" : "frame.csv", line),
                   "may be cut off");
  });
}

// A cell of a row, in the middle or at the end of the file.
TEST(Recordings, WithACellThatIsNoNumberAreRefusedWithItsLine) {
  const std::string words[] = {"",  "nan", "NaN",   "inf",  "-inf", "-0.",  "1.",
                               "-", "1,5", "1e999", "12 N", "OL",   "0x10", "1.5.2"};
  for_each_drawn([&words](Drawn& d) {
    const bool lcr = d.below(2) == 0;
    const MadeFile& file = lcr ? d.lcr : d.frame;
    const std::size_t row = d.below(file.rows.size());
    const std::string& word = words[d.below(std::size(words))];
    const auto t = fmt::format("{:.4f}", file.rows[row].t_s);
    std::string line;
    switch (d.below(3)) {
      case 0: line = word + ",1,2\n"; break;
      case 1: line = t + "," + word + ",2\n"; break;
      default: line = t + ",1," + word + "\n"; break;
    }
    Files files{d.lcr.text(), d.frame.text()};
    (lcr ? files.lcr : files.frame) = with_row(file, row, line);
    expect_refused(loaded(files), fmt::format("{}:{}", lcr ? "lcr.csv" : "frame.csv", row + 2),
                   word == "1,5" ? "cells, but the header has 3" : "expected a number");
  });
}

TEST(Recordings, WithTimesThatDoNotGrowAreRefusedWithTheLine) {
  for_each_drawn([](Drawn& d) {
    const bool lcr = d.below(2) == 0;
    MadeFile& file = lcr ? d.lcr : d.frame;
    const std::size_t row = 1 + d.below(file.rows.size() - 1);
    file.rows[row].t_s = file.rows[row - 1].t_s - (d.below(2) == 0 ? 0 : d.even() + 1e-3);
    expect_refused(loaded({d.lcr.text(), d.frame.text()}),
                   fmt::format("{}:{}", lcr ? "lcr.csv" : "frame.csv", row + 2),
                   "expected times that grow");
  });
}

TEST(Recordings, WithARowOfOtherLengthAreRefusedWithItsLine) {
  for_each_drawn([](Drawn& d) {
    const std::size_t row = d.below(d.frame.rows.size());
    const auto t = fmt::format("{:.4f}", d.frame.rows[row].t_s);
    const std::string line = d.below(2) == 0 ? t + ",0.1\n" : t + ",0,1,2,5\n";
    expect_refused(loaded({d.lcr.text(), with_row(d.frame, row, line)}),
                   fmt::format("frame.csv:{}", row + 2), "but the header has 3");
  });
}

TEST(Recordings, AskForTheirColumnsByName) {
  const Drawn d(1);
  const std::string lcr = d.lcr.text(), frame = d.frame.text();
  struct Case {
    std::string from, to, expected;
  };
  for (const Case& c :
       {Case{"t_s,Cp_F", "time,Cp_F", "no column `t_s`"}, Case{"Cp_F", "C", "no column `Cp_F`"},
        Case{"t_s,Cp_F", "t_s;Cp_F", "the header is `t_s;Cp_F,Rp_ohm`"},
        Case{"Rp_ohm", "Cp_F", "the column `Cp_F` stands twice (columns 2 and 3)"},
        Case{"Rp_ohm", "t_s", "the column `t_s` stands twice (columns 1 and 3)"},
        Case{"Rp_ohm", "t_middle_s", "keep one of the columns"},
        Case{"t_s", std::string("t\0s", 3), "not UTF-8"}, Case{"t_s", "\xff\xfet_s", "not UTF-8"},
        Case{"t_s,", "t_s\r1,", "CR alone"}}) {
    auto text = lcr;
    text.replace(text.find(c.from), c.from.size(), c.to);
    expect_refused(loaded({text, frame}), "lcr.csv:1:", c.expected);
  }
  const auto second = replaced(frame, "force_N", "force_N,force_N");
  expect_refused(loaded({lcr, second}), "frame.csv:1:", "stands twice");
  const auto of_middle = loaded({replaced(lcr, "t_s", "t_middle_s"), frame});
  ASSERT_TRUE(of_middle) << of_middle.error().what;
  EXPECT_TRUE(of_middle->of_middle);
  EXPECT_FALSE(loaded({lcr, frame})->of_middle);
}

TEST(Recordings, NeedBothFilesWithRows) {
  const Drawn d(2);
  const std::string lcr = d.lcr.text(), frame = d.frame.text();
  expect_refused(loaded({lcr, std::nullopt}), "frame.csv", "needs lcr.csv and frame.csv");
  expect_refused(loaded({std::nullopt, frame}), "lcr.csv", "needs lcr.csv and frame.csv");
  expect_refused(loaded({lcr, ""}), "frame.csv", "is empty");
  expect_refused(loaded({lcr, d.frame.header + "\n"}), "frame.csv", "no rows");
  expect_refused(loaded({d.lcr.header + "\n", frame}), "lcr.csv", "no rows");
}

}  // namespace
}  // namespace lcrig
