// SPDX-License-Identifier: Apache-2.0
// Checks the corpora of wrong files that a C++ parser and its JSON schema share.
// tests/corpus/check_schema.py checks the same files against the schema.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "base/strict_json.hpp"

namespace lcrig::corpus {

inline std::vector<std::filesystem::path> files(const std::string& folder) {
  std::vector<std::filesystem::path> out;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") out.push_back(entry.path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

// The WORDS of "// expect: WORDS" in the first line.
inline std::string expectation(const std::string& text) {
  const std::string mark = "// expect: ";
  if (!text.starts_with(mark)) return {};
  return text.substr(mark.size(), text.find('\n') - mark.size());
}

// `parse(text, name)`, which returns a Result, must refuse every file with a position and with the
// words that the file expects.
template <class Parse>
void expect_all_refused(const std::string& folder, std::size_t at_least, Parse parse) {
  const auto all = files(folder);
  EXPECT_GE(all.size(), at_least);
  for (const auto& path : all) {
    const auto text = read_text_file(path);
    ASSERT_TRUE(text);
    const std::string expected = expectation(*text);
    ASSERT_FALSE(expected.empty()) << path << " does not say what to expect";
    const auto r = parse(*text, path.filename().string());
    if (r) {
      ADD_FAILURE() << path << ": accepted";
      continue;
    }
    EXPECT_EQ(r.error().code, Errc::invalid_request) << path;
    EXPECT_THAT(r.error().what, testing::HasSubstr(expected)) << path;
    EXPECT_THAT(r.error().what, testing::ContainsRegex("^[a-z_0-9]+\\.json:[0-9]+:[0-9]+ /"))
        << path;
  }
}

}  // namespace lcrig::corpus
