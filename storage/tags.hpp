// SPDX-License-Identifier: Apache-2.0
// Tags: words that people put on runs to find them again, and may remove. They are not part of the
// record, so the hash chain does not cover them. Used by the daemon and the command line.
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

// A tag is one word without blanks, commas, steering characters or a leading dash.
Result<> check_tag(std::string_view tag);

struct TagChange {
  std::int64_t run = 0;
  std::vector<std::string> tags;
  bool remove = false;
};
// Makes all changes or none; a tag that is there already is no error. The run may still be going
// on. Returns its tags afterwards. Errors: invalid_request (no such run, a tag to remove that it
// lacks, not a valid tag).
Result<std::vector<std::string>> change_tags(const Database& db, const TagChange& change,
                                             std::string_view operator_name,
                                             std::int64_t now_unix_ns);

// In alphabetical order; empty for a schema without tags.
Result<std::vector<std::string>> get_tags_of(const Database& db, std::int64_t run);
Result<std::map<std::int64_t, std::vector<std::string>>> get_tags(const Database& db);

}  // namespace lcrig
