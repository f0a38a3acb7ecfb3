// SPDX-License-Identifier: Apache-2.0
// Makes one mistake after the other in a good file. Each must be reported, and nothing that only
// follows from it.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig::support {

// Parses a text that is called f.json.
using ParseFile = std::function<Result<>(const std::string& text)>;

inline std::vector<std::string> mistakes_in(const std::string& text, const ParseFile& parse) {
  const auto parsed = parse(text);
  if (parsed) return {};
  std::vector<std::string> out{parsed.error().what};
  std::istringstream in(parsed.error().detail);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("f.json:")) out.push_back(line);
  }
  return out;
}

inline std::string lines_of(const std::vector<std::string>& words) {
  std::string out;
  for (const auto& line : words) out += line + "\n";
  return out;
}

// Replaces each value by one of a wrong type. Returns how many were tried.
inline int expect_each_wrong_value_said_once(const nlohmann::json& good, const ParseFile& parse) {
  using nlohmann::json;
  int tried = 0;
  const json flat = good.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    json bad = good;
    if (good[json::json_pointer(pointer)].empty()) continue;  // [] or {}
    bad[json::json_pointer(pointer)] = json::object();
    const auto said = mistakes_in(bad.dump(), parse);
    EXPECT_EQ(said.size(), 1U) << pointer << "\n" << lines_of(said);
    ++tried;
  }
  return tried;
}

// Removes each key, then mistypes it. `free_names` is the object whose keys are names that the file
// itself chooses and uses.
inline void expect_each_wrong_key_said_once(const nlohmann::json& good, const ParseFile& parse,
                                            const std::string& free_names) {
  using nlohmann::json;
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
    auto said = mistakes_in(bad.dump(), parse);
    // If a name is missing, every use of it is wrong, too.
    if (above != free_names && key.to_string() != free_names) {
      EXPECT_LE(said.size(), 1U) << key << " is missing\n" << lines_of(said);
    }
    if (above == free_names) continue;
    object[key.back() + "x"] = value;
    said = mistakes_in(bad.dump(), parse);
    EXPECT_EQ(said.size(), 1U) << key << " is mistyped\n" << lines_of(said);
  }
}

}  // namespace lcrig::support
