// SPDX-License-Identifier: Apache-2.0
// Specimens, versioned by content: a changed file is a new version of its name.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "storage/sqlite.hpp"

namespace lcrig {

struct StoredSpecimen {
  std::int64_t id = 0;
  std::string name;
  std::int64_t version = 0;
  std::string sha256;  // of text, hex
  std::string text;  // the file as it was
  std::int64_t added_unix_ns = 0;
};

// Stores `text` as the newest version of `name`; the same content again is the same row.
Result<StoredSpecimen> add_specimen(const Database& db, const std::string& name,
                                    const std::string& text, std::int64_t now_unix_ns);
// The newest version, or nothing.
Result<std::optional<StoredSpecimen>> find_specimen(const Database& db, std::string_view name);
// The newest version of every name, by name.
Result<std::vector<StoredSpecimen>> list_specimens(const Database& db);

}  // namespace lcrig
