// SPDX-License-Identifier: Apache-2.0
// The corpus that parser and JSON schema share (tests/corpus/check_schema.py has the other half).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocols/file/parse.hpp"
#include "tests/support/corpus.hpp"

namespace lcrig {
namespace {

TEST(ProtocolCorpus, EveryBadFileIsRefusedWithPointerAndReason) {
  corpus::expect_all_refused("tests/corpus/protocol/reject", 40, parse_protocol);
}

TEST(ProtocolCorpus, WhatOnlySemanticsSeeIsRefusedToo) {
  corpus::expect_all_refused("tests/corpus/protocol/reject_semantic", 20, parse_protocol);
}

TEST(ProtocolCorpus, EveryGoodFileIsAccepted) {
  const auto all = corpus::files("tests/corpus/protocol/accept");
  EXPECT_GE(all.size(), 5U);
  for (const auto& path : all) {
    const auto r = load_protocol(path);
    EXPECT_TRUE(r) << r.error().what;
  }
}

TEST(ProtocolCorpus, TheShippedLibraryIsAcceptedAndNamedLikeItsFiles) {
  const auto all = corpus::files("protocols/library");
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
