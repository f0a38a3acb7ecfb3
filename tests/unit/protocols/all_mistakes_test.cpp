// SPDX-License-Identifier: Apache-2.0
// A person corrects a file once: all of its mistakes are reported together, and none that only
// follows from another.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/strict_json.hpp"
#include "protocols/file/parse.hpp"
#include "tests/support/file_mistakes.hpp"

namespace lcrig {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Result<> parse(const std::string& text) {
  const auto protocol = parse_protocol(text, "f.json");
  if (!protocol) return fail(protocol.error());
  return {};
}

std::vector<json> shipped() {
  std::vector<json> out;
  for (const auto& entry : std::filesystem::directory_iterator("protocols/library")) {
    const auto document = load_json(entry.path().string());
    EXPECT_TRUE(document) << entry.path();
    out.push_back(document->root());
  }
  return out;
}

TEST(AllMistakes, OfEverySectionAreSaidFromTheTop) {
  const auto said = support::mistakes_in(R"({ "format": "load-protocol/1", "name": "my press",
  "parameters": { "force_N": { "default": 9, "min": 0, "max": 5 } },
  "limits": { "force_N": [-0.2, 6], "travel_mm": [2, 1] },
  "sample": { "lcr": { "function": "Cp", "frequency_kHz": 1, "level_V": 1, "aperture": "fast" } },
  "steps": [
    { "id": "press", "do": "rammp", "to": { "force_N": 1 } },
    { "id": "press", "do": "hold", "hold": "travel", "fro_s": 3 },
    { "id": "level", "do": "measure", "count": 0, "within_s": "$force_N" } ],
  "finallx": [] })",
                                         parse);
  EXPECT_THAT(
      said,
      ElementsAre(HasSubstr("f.json:1:40 /name: "), HasSubstr(":2:43 /parameters/"),
                  HasSubstr(":3:50 /limits/travel_mm: "), HasSubstr(":4:36 /sample/lcr/function: "),
                  HasSubstr(":6:28 /steps/0/do: "), HasSubstr(":7:13 /steps/1/id: "),
                  AllOf(HasSubstr(":7:54 /steps/1/fro_s: "), HasSubstr("`for_s`")),
                  HasSubstr(":8:48 /steps/2/count: "), HasSubstr(":8:63 /steps/2/within_s: "),
                  AllOf(HasSubstr(":9:3 /finallx: "), HasSubstr("`finally`"))));
}

TEST(AllMistakes, AWrongValueIsOneMistake) {
  int tried = 0;
  for (const json& good : shipped()) {
    tried += support::expect_each_wrong_value_said_once(good, parse);
  }
  EXPECT_GT(tried, 200);
}

TEST(AllMistakes, AMistypedKeyIsOneMistake) {
  for (const json& good : shipped()) {
    support::expect_each_wrong_key_said_once(good, parse, "/parameters");
  }
}

}  // namespace
}  // namespace lcrig
