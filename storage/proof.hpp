// SPDX-License-Identifier: Apache-2.0
// Which readings of a run are proven: taken between two equal read-backs of the meter's settings.
// The rule stands here for all programs, and in SQL for the views (schema/sql/0011_proof.sql).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "events/event_kind.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// Readings asked in this span, both ends included.
struct AskedSpan {
  std::int64_t from_mono_ns = 0, to_mono_ns = 0;
  bool operator==(const AskedSpan&) const = default;
};

// A reading is proven unless an event `unproven` names it, or it was asked after the last read-back
// that was equal. So what a crash leaves is unproven. In a run without any event `read_back`, which
// an older lcrig recorded, the proof is unknown, and every reading counts.
class Proof {
 public:
  // Errors: those of the database; garbled, when an event cannot be read.
  static Result<Proof> load(const Database& db, std::int64_t run);

  bool is_known() const { return known_; }
  // In ascending order, without overlaps. The last one has no end where the last read-back was not
  // followed by another one. Empty when the proof is unknown.
  const std::vector<AskedSpan>& unproven() const { return unproven_; }

 private:
  bool known_ = false;
  std::vector<AskedSpan> unproven_;
};

// Looks readings up in the order in which they were asked; another order costs a search. The proof
// must outlive it.
class ProofWalk {
 public:
  explicit ProofWalk(const Proof& proof) : spans_(proof.unproven()) {}
  bool is_proven(std::int64_t asked_mono_ns);

 private:
  const std::vector<AskedSpan>& spans_;
  std::size_t next_ = 0;  // the first span that ends at `last_` or later
  std::int64_t last_ = INT64_MIN;
};

// Fresh readings of a run that are not proven.
Result<std::int64_t> count_unproven(const Database& db, std::int64_t run);
// SQL that is true for a run of the table `run` that may have such readings, quickly. "0" for a
// schema that knows no proof.
Result<std::string_view> may_be_unproven_sql(const Database& db);

}  // namespace lcrig
