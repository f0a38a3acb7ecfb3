// SPDX-License-Identifier: Apache-2.0
// Words that people put on runs to find them again, and take off again. They are not part of what
// was recorded: the hash chain does not cover them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

constexpr std::size_t kTagMax = 60;  // bytes

// A tag is a word: no blank, no comma, nothing that steers a terminal, and no dash in front.
Result<> check_tag(std::string_view tag);

struct TagChange {
  std::int64_t run = 0;
  std::vector<std::string> tags;
  bool remove = false;
};
// All of it or nothing; what is so already stays so. Also of a run that goes on. Returns the tags
// that the run has then. Errors: invalid_request (no such run, no tag of it to remove, no word).
Result<std::vector<std::string>> change_tags(const Database& db, const TagChange& change,
                                             std::string_view operator_name,
                                             std::int64_t now_unix_ns);

// In the order of the alphabet; none of a schema without tags.
Result<std::vector<std::string>> get_tags_of(const Database& db, std::int64_t run);
Result<std::map<std::int64_t, std::vector<std::string>>> get_tags(const Database& db);

}  // namespace lcrig
