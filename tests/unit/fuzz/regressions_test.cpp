// SPDX-License-Identifier: Apache-2.0
// Feeds every seed, and every input that ever caused a crash, to the functions that libFuzzer calls
// (tools/check/fuzz). What was mended must stay mended with every compiler and sanitizer.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> out;
  if (!fs::is_directory(folder)) return out;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) out.push_back(entry.path());
  }
  std::ranges::sort(out);
  return out;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream out;
  out << file.rdbuf();
  return out.str();
}

class Fuzz : public testing::TestWithParam<Target> {
 protected:
  static fs::path folder(const char* kind) {
    return fs::path("tests/fuzz") / kind / GetParam().name;
  }
  static void expect_all_hold(const std::vector<fs::path>& inputs) {
    for (const auto& path : inputs) EXPECT_NO_THROW(GetParam().read(bytes_of(path))) << path;
  }
};

TEST_P(Fuzz, EverySeedHoldsItsProperties) {
  const auto seeds = files_below(folder("corpus"));
  EXPECT_GE(seeds.size(), 3U) << "no seeds below " << folder("corpus");
  expect_all_hold(seeds);
  if (GetParam().more.empty()) return;
  const auto more = files_below(GetParam().more);
  EXPECT_GE(more.size(), 1U) << GetParam().more;
  expect_all_hold(more);
}

TEST_P(Fuzz, EveryInputThatCrashedHoldsItsProperties) {
  expect_all_hold(files_below(folder("crashes")));
}

// A fuzzer that mutates seeds would find these by chance; here they are always tried.
TEST_P(Fuzz, CutAndDamagedSeedsHoldTheirProperties) {
  for (const auto& path : files_below(folder("corpus"))) {
    const std::string good = bytes_of(path);
    const std::size_t step = std::max<std::size_t>(1, good.size() / 50);
    for (std::size_t at = 0; at < good.size(); at += step) {
      std::string damaged = good;
      damaged[at] = static_cast<char>(~damaged[at]);
      EXPECT_NO_THROW(GetParam().read(good.substr(0, at))) << path << " cut at " << at;
      EXPECT_NO_THROW(GetParam().read(damaged)) << path << " damaged at " << at;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(kTargets),
                         [](const auto& target) { return std::string(target.param.name); });

TEST(FuzzRequire, SeesWhatATargetMustNotLetThrough) {
  EXPECT_THROW(require(false, "x"), std::logic_error);
  EXPECT_THROW(require_good_message(""), std::logic_error);
  EXPECT_THROW(require_good_message("a\x1b[31m"), std::logic_error);
  EXPECT_THROW(require_good_message("two\nlines"), std::logic_error);
  EXPECT_THROW(require_good_message(std::string(100'000, 'x')), std::logic_error);
  EXPECT_THROW(require_good_message(Error(Errc::bug, "ours")), std::logic_error);
  EXPECT_NO_THROW(require_good_message("f.json:1:2 /a: 3, expected a string"));
}

}  // namespace
}  // namespace lcrig::fuzz
