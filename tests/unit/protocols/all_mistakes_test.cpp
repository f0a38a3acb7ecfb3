// SPDX-License-Identifier: Apache-2.0
// A person corrects a file once: every mistake of it is said at once, and none that only follows
// from another.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/strict_json.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> mistakes_in(const std::string& text) {
  const auto protocol = parse_protocol(text, "f.json");
  if (protocol) return {};
  std::vector<std::string> out{protocol.error().what};
  std::istringstream in(protocol.error().detail);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("f.json:")) out.push_back(line);
  }
  return out;
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

std::string shown(const std::vector<std::string>& lines) {
  std::string out;
  for (const auto& line : lines) out += line + "\n";
  return out;
}

TEST(AllMistakes, OfEverySectionAreSaidFromTheTop) {
  const auto said = mistakes_in(R"({ "format": "load-protocol/1", "name": "my press",
  "parameters": { "force_N": { "default": 9, "min": 0, "max": 5 } },
  "limits": { "force_N": [-0.2, 6], "travel_mm": [2, 1] },
  "sample": { "lcr": { "function": "Cp", "frequency_kHz": 1, "level_V": 1, "aperture": "fast" } },
  "steps": [
    { "id": "press", "do": "rammp", "to": { "force_N": 1 } },
    { "id": "press", "do": "hold", "hold": "travel", "fro_s": 3 },
    { "id": "level", "do": "measure", "count": 0, "within_s": "$force_N" } ],
  "finallx": [] })");
  EXPECT_THAT(
      said,
      ElementsAre(HasSubstr("f.json:1:40 /name: "), HasSubstr(":2:43 /parameters/"),
                  HasSubstr(":3:50 /limits/travel_mm: "), HasSubstr(":4:36 /sample/lcr/function: "),
                  HasSubstr(":6:28 /steps/0/do: "), HasSubstr(":7:13 /steps/1/id: "),
                  AllOf(HasSubstr(":7:54 /steps/1/fro_s: "), HasSubstr("`for_s`")),
                  HasSubstr(":8:48 /steps/2/count: "), HasSubstr(":8:63 /steps/2/within_s: "),
                  AllOf(HasSubstr(":9:3 /finallx: "), HasSubstr("`finally`"))));
}

// Each value of each shipped protocol becomes one of a wrong type.
TEST(AllMistakes, AWrongValueIsOneMistake) {
  int tried = 0;
  for (const json& good : shipped()) {
    const json flat = good.flatten();
    for (const auto& [pointer, value] : flat.items()) {
      json bad = good;
      if (good[json::json_pointer(pointer)].empty()) continue;  // [] or {}
      bad[json::json_pointer(pointer)] = json::object();
      const auto said = mistakes_in(bad.dump());
      EXPECT_EQ(said.size(), 1U) << pointer << "\n" << shown(said);
      ++tried;
    }
  }
  EXPECT_GT(tried, 200);
}

// Each key of each object in turn is missing, then mistyped.
TEST(AllMistakes, AMistypedKeyIsOneMistake) {
  for (const json& good : shipped()) {
    std::vector<json::json_pointer> keys;
    const json flat = good.flatten();
    for (const auto& [pointer, value] : flat.items()) {
      for (json::json_pointer at(pointer); !at.empty(); at.pop_back()) {
        if (good[at.parent_pointer()].is_object()) keys.push_back(at);
      }
    }
    for (const auto& key : keys) {
      const auto above = key.parent_pointer().to_string();
      json bad = good;
      json& object = bad[key.parent_pointer()];
      const json value = object[key.back()];
      object.erase(key.back());
      auto said = mistakes_in(bad.dump());
      // Of a parameter that is not there each use is wrong.
      const bool used = above == "/parameters" || key.to_string() == "/parameters";
      if (!used) {
        EXPECT_LE(said.size(), 1U) << key << " is missing\n" << shown(said);
      }
      if (above == "/parameters") continue;  // names are free
      object[key.back() + "x"] = value;
      said = mistakes_in(bad.dump());
      EXPECT_EQ(said.size(), 1U) << key << " is mistyped\n" << shown(said);
    }
  }
}

}  // namespace
}  // namespace lcrig
