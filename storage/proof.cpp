// SPDX-License-Identifier: Apache-2.0
#include "storage/proof.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "events/payloads.hpp"

namespace lcrig {

namespace {

constexpr std::int64_t kFirstWithProof = 11;  // schema
constexpr std::int64_t kEver = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kForEver = std::numeric_limits<std::int64_t>::max();

// What the events of a run say, in their order.
struct Said {
  bool read_back = false;
  std::optional<std::int64_t> last_equal_ns;
  std::vector<AskedSpan> spans;

  Result<> add(std::int64_t at_ns, EventKind kind, std::string_view detail) {
    if (kind == EventKind::unproven) return add_span(detail);
    if (kind == EventKind::read_back) {
      read_back = true;
      auto equal = from_json<ReadBackEvent>(detail);
      if (!equal) return fail(equal.error());
      if (!equal->equal) return {};
    }
    last_equal_ns = std::max(at_ns, last_equal_ns.value_or(at_ns));
    return {};
  }
  Result<> add_span(std::string_view detail) {
    auto span = from_json<UnprovenEvent>(detail);
    if (!span) return fail(span.error());
    if (span->asked_from_mono_ns > span->asked_to_mono_ns) return {};
    spans.push_back({span->asked_from_mono_ns, span->asked_to_mono_ns});
    return {};
  }
};

std::vector<AskedSpan> merged(std::vector<AskedSpan> spans) {
  std::ranges::sort(spans, {}, &AskedSpan::from_mono_ns);
  std::vector<AskedSpan> out;
  for (const AskedSpan& span : spans) {
    if (!out.empty() && span.from_mono_ns <= out.back().to_mono_ns) {
      out.back().to_mono_ns = std::max(out.back().to_mono_ns, span.to_mono_ns);
    } else {
      out.push_back(span);
    }
  }
  return out;
}

}  // namespace

Result<Proof> Proof::load(const Database& db, std::int64_t run) {
  Said said;
  const auto take = [&](const Statement& row) -> Result<> {
    const auto kind = parse_word<EventKind>(row.text(1)).value_or(EventKind::other);
    auto added = said.add(row.integer(0), kind, row.text(2));
    if (added) return added;
    return fail(Errc::garbled, "run {}: event {} (`{}`) cannot be read: {}; `lcrig verify {}`", run,
                row.integer(3), to_string(kind), added.error().what, run);
  };
  auto all = db.each(
      "SELECT at_mono_ns, kind, detail, seq FROM event WHERE run_id = ? AND kind IN (?, ?, ?)"
      " ORDER BY seq",
      take, run, EventKind::settings, EventKind::read_back, EventKind::unproven);
  if (!all) return fail(all.error());
  Proof out;
  out.known_ = said.read_back;
  if (!out.known_) return out;
  said.spans.push_back({said.last_equal_ns.value_or(kEver), kForEver});
  out.unproven_ = merged(std::move(said.spans));
  return out;
}

bool ProofWalk::is_proven(std::int64_t asked_mono_ns) {
  if (asked_mono_ns < last_) {
    const auto at = std::ranges::lower_bound(spans_, asked_mono_ns, {}, &AskedSpan::to_mono_ns);
    next_ = static_cast<std::size_t>(at - spans_.begin());
  }
  last_ = asked_mono_ns;
  while (next_ < spans_.size() && spans_[next_].to_mono_ns < asked_mono_ns) ++next_;
  return next_ == spans_.size() || asked_mono_ns < spans_[next_].from_mono_ns;
}

Result<std::int64_t> count_unproven(const Database& db, std::int64_t run) {
  auto proof = Proof::load(db, run);
  if (!proof) return fail(proof.error());
  if (!proof->is_known()) return 0;
  ProofWalk walk(*proof);
  std::int64_t count = 0;
  auto all = db.each(
      "SELECT asked_mono_ns FROM lcr_reading WHERE run_id = ? AND fresh ORDER BY seq",
      [&](const Statement& row) { count += walk.is_proven(row.integer(0)) ? 0 : 1; }, run);
  if (!all) return fail(all.error());
  return count;
}

Result<std::string_view> may_be_unproven_sql(const Database& db) {
  auto schema = db.integer("PRAGMA user_version");
  if (!schema) return fail(schema.error());
  if (*schema < kFirstWithProof) return "0";
  // The conditions have the words of the indexes of schema/sql/0011_proof.sql.
  return "(EXISTS (SELECT 1 FROM event AS e INDEXED BY event_unproven WHERE e.run_id = run.id AND"
         " e.kind = 'unproven') OR (EXISTS (SELECT 1 FROM event AS e INDEXED BY event_read_back"
         " WHERE e.run_id = run.id AND e.kind = 'read_back') AND NOT EXISTS (SELECT 1 FROM event"
         " AS e INDEXED BY event_proof WHERE e.run_id = run.id AND e.at_mono_ns >"
         " (SELECT asked_mono_ns FROM lcr_reading AS l WHERE l.run_id = run.id ORDER BY seq DESC"
         " LIMIT 1) AND CASE e.kind WHEN 'settings' THEN 1 WHEN 'read_back' THEN CASE WHEN"
         " json_valid(e.detail) THEN json_extract(e.detail, '$.equal') END END)))";
}

}  // namespace lcrig
