// SPDX-License-Identifier: Apache-2.0
#include "base/name_rule.hpp"

#include <gmock/gmock.h>

namespace lcrig {
namespace {

using ::testing::HasSubstr;

TEST(NameRule, TakesWhatCanBeTypedAgain) {
  for (const char* name : {"paper-1", "two words", "it's $HOME `ls`", "a\"b\\c", "100 %!", "Größe",
                           "日本", ".hidden", "x.json.old", "a=b", "[1,2]", "~", "Replay"}) {
    EXPECT_EQ(why_no_name(name), std::nullopt) << name;
  }
  EXPECT_FALSE(why_no_name(std::string(60, 'x')));
}

TEST(NameRule, RefusesWhatItsOwnCommandsWouldTakeForSomethingElse) {
  const std::pair<std::string, const char*> bad[] = {{"", "empty"},
                                                     {"a/b", "slash"},
                                                     {"/", "slash"},
                                                     {"-x", "dash"},
                                                     {"--json", "dash"},
                                                     {"x.json", ".json"},
                                                     {"replay:x", "replay"},
                                                     {" x", "space at one end"},
                                                     {"x ", "space at one end"},
                                                     {"a\nb", "printed"},
                                                     {"a\tb", "printed"},
                                                     {"a\xE2\x80\xAE"
                                                      "b",
                                                      "printed"},
                                                     {"\xff", "printed"},
                                                     {std::string(61, 'x'), "at most 60"},
                                                     {"a\xC2\xA0"
                                                      "b",
                                                      "invisible"},
                                                     {"a\xE2\x80\x8B"
                                                      "b",
                                                      "invisible"}};
  for (const auto& [name, why] : bad) {
    const auto told = why_no_name(name);
    ASSERT_TRUE(told) << name;
    EXPECT_THAT(*told, HasSubstr(why)) << name;
  }
}

}  // namespace
}  // namespace lcrig
