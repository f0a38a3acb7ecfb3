// SPDX-License-Identifier: Apache-2.0
// People correct specimens, benches and config files once, too, like protocols (unit/protocols).
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/strict_json.hpp"
#include "daemon/config.hpp"
#include "daemon/rig/bench.hpp"
#include "model/specimen_file.hpp"
#include "tests/support/file_mistakes.hpp"

namespace lcrig {
namespace {

using nlohmann::json;

template <class T>
Result<> without_value(const Result<T>& parsed) {
  if (!parsed) return fail(parsed.error());
  return {};
}

struct Kind {
  const char* folder;
  support::ParseFile parse;
  const char* free_names;
};

TEST(AllMistakesOfOtherFiles, AreEachSaidOnce) {
  constexpr const char* kNone = "no names";
  const Kind kinds[] = {
      {"model/library",
       [](const std::string& text) { return without_value(parse_specimen(text, "f.json")); },
       "/materials"},
      {"daemon/rig/benches",
       [](const std::string& text) { return without_value(parse_bench(text, "f.json")); }, kNone},
      {"tests/corpus/config/accept",
       [](const std::string& text) { return without_value(parse_config(text, "f.json")); }, kNone}};
  for (const Kind& kind : kinds) {
    for (const auto& entry : std::filesystem::directory_iterator(kind.folder)) {
      SCOPED_TRACE(entry.path());
      const auto document = load_json(entry.path().string());
      ASSERT_TRUE(document);
      // Without its bench the file lacks all instruments.
      if (entry.path().filename() == "bench.json") continue;
      EXPECT_GT(support::expect_each_wrong_value_said_once(document->root(), kind.parse), 2);
      support::expect_each_wrong_key_said_once(document->root(), kind.parse, kind.free_names);
    }
  }
}

}  // namespace
}  // namespace lcrig
