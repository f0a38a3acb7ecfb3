// SPDX-License-Identifier: Apache-2.0
// The anchor of a run's hash chain (storage/chain.hpp): the number of its links and the hash of the
// last one. People keep it outside of the database, so that `lcrig verify` detects a chain that was
// rebuilt. It is short enough for a journal line and a lab book.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "storage/row_hash.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

struct Anchor {
  std::int64_t links = 0;
  Sha256 hash{};
  bool operator==(const Anchor&) const = default;
};
std::string to_string(const Anchor& anchor);  // "57:" and 64 hex digits
Result<Anchor> parse_anchor(std::string_view text);

// The anchor stored when the run ended. nullopt: the run has not ended, or it ended under a schema
// without anchors.
Result<std::optional<Anchor>> get_anchor(const Database& db, std::int64_t run);
// For a run that was closed just now: the stored anchor, if it differs from that of this closing.
// Then the run had ended before, and somebody deleted its end. nullopt: it had not.
Result<std::optional<Anchor>> get_earlier_anchor(const Database& db, std::int64_t run);
// The run that ended with this anchor.
Result<std::optional<std::int64_t>> find_run_of(const Database& db, const Anchor& anchor);

}  // namespace lcrig
