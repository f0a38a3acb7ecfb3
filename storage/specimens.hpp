// SPDX-License-Identifier: Apache-2.0
// Stored specimen files, versioned by content: a changed file becomes a new version of its name.
// Used by the daemon and by `lcrig specimen`.
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
  std::string sha256;  // of `text`, in hex
  std::string text;  // the whole file
  std::int64_t added_unix_ns = 0;
};

// Stores `text` as the newest version of `name`, unless the newest version already has this
// content. Returns that version.
Result<StoredSpecimen> add_specimen(const Database& db, const std::string& name,
                                    const std::string& text, std::int64_t now_unix_ns);
// The newest version, if the name is known.
Result<std::optional<StoredSpecimen>> find_specimen(const Database& db, std::string_view name);
// The newest version of every name, sorted by name.
Result<std::vector<StoredSpecimen>> list_specimens(const Database& db);

}  // namespace lcrig
