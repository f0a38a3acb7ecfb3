// SPDX-License-Identifier: Apache-2.0
// The corpus that parser and JSON schema share (tests/corpus/check_schema.py runs the other half).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/strict_json.hpp"
#include "protocols/parse.hpp"

namespace lcrig {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files(const std::string& folder) {
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") out.push_back(entry.path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

// "// expect: WORDS" in the first line.
std::string expectation(const std::string& text) {
  static const std::string kMark = "// expect: ";
  if (!text.starts_with(kMark)) return {};
  return text.substr(kMark.size(), text.find('\n') - kMark.size());
}

void expect_all_refused(const std::string& folder, std::size_t at_least) {
  const auto all = files(folder);
  EXPECT_GE(all.size(), at_least);
  for (const auto& path : all) {
    const auto text = read_text_file(path);
    ASSERT_TRUE(text);
    const std::string expected = expectation(*text);
    ASSERT_FALSE(expected.empty()) << path << " does not say what to expect";
    const auto r = parse_protocol(*text, path.filename());
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

TEST(ProtocolCorpus, EveryBadFileIsRefusedWithPointerAndReason) {
  expect_all_refused("tests/corpus/protocol/reject", 40);
}

TEST(ProtocolCorpus, WhatOnlySemanticsSeeIsRefusedToo) {
  expect_all_refused("tests/corpus/protocol/reject_semantic", 20);
}

TEST(ProtocolCorpus, EveryGoodFileIsAccepted) {
  const auto all = files("tests/corpus/protocol/accept");
  EXPECT_GE(all.size(), 5U);
  for (const auto& path : all) {
    const auto r = load_protocol(path);
    EXPECT_TRUE(r) << r.error().what;
  }
}

TEST(ProtocolCorpus, TheShippedLibraryIsAcceptedAndNamedLikeItsFiles) {
  const auto all = files("protocols/library");
  EXPECT_GE(all.size(), 6U);
  for (const auto& path : all) {
    const auto r = load_protocol(path);
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->name, path.stem());
    EXPECT_FALSE(r->description.empty()) << path;
    for (const auto& [name, p] : r->parameters) EXPECT_FALSE(p.description.empty()) << name;
  }
}

TEST(ProtocolCorpus, TheDocumentedExampleIsAccepted) {
  const auto page = read_text_file("docs/protocol-file.md");
  ASSERT_TRUE(page) << page.error().what;
  const auto begin = page->find("```json\n") + 8;
  const auto r = parse_protocol(page->substr(begin, page->find("```", begin) - begin), "doc.json");
  EXPECT_TRUE(r) << r.error().what;
}

}  // namespace
}  // namespace lcrig
