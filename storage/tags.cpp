// SPDX-License-Identifier: Apache-2.0
#include "storage/tags.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "storage/database.hpp"

namespace lcrig {

namespace {

// Unicode white space beyond ASCII, and characters without width. With them two tags could look the
// same.
bool is_wide_or_hidden_blank(char32_t c) {
  const bool space = c == 0xA0 || c == 0x1680 || c == 0x202F || c == 0x205F || c == 0x3000;
  return space || (c >= 0x2000 && c <= 0x200D) || c == 0x2060 || c == 0xFEFF;
}

bool has_odd_blank(std::string_view text) {
  while (!text.empty()) {
    if (is_wide_or_hidden_blank(take_character(text))) return true;
  }
  return false;
}

}  // namespace

Result<> check_tag(std::string_view tag) {
  if (auto good = check_text("tag", tag, kTagMax); !good) return good;
  const bool word = !tag.empty() && tag.front() != '-' && tag.find_first_of(" ,") == tag.npos &&
                    printable(tag) == tag && !has_odd_blank(tag);
  if (word) return {};
  return fail(Errc::invalid_request,
              "tag \"{}\": a tag is one word, without blanks and commas, and begins with no dash",
              printable(tag));
}

Result<std::vector<std::string>> change_tags(const Database& db, const TagChange& change,
                                             std::string_view operator_name,
                                             std::int64_t now_unix_ns) {
  if (change.tags.empty()) return fail(Errc::invalid_request, "no tag is named");
  for (const auto& tag : change.tags) {
    if (auto good = check_tag(tag); !good) return fail(good.error());
  }
  if (auto good = check_text("operator", operator_name, kNameMax); !good) return fail(good.error());
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto there = db.holds("SELECT count(*) FROM run WHERE id = ?", change.run);
  if (!there) return fail(there.error());
  if (!*there) return fail(no_such_run(db, change.run));
  for (const auto& tag : change.tags) {
    auto now = get_tags_of(db, change.run);
    if (!now) return now;
    const bool present = std::ranges::count(*now, tag) > 0;
    if (change.remove && !present) {
      return fail(Errc::invalid_request, "run {} has no tag {}: nothing was changed", change.run,
                  tag);
    }
    if (present && !change.remove) continue;
    auto changed = db.change(
        "INSERT INTO run_tag SELECT ?1, coalesce(max(seq), 0) + 1, ?2, ?3, ?4, ?5 FROM run_tag"
        " WHERE run_id = ?1",
        change.run, std::string_view(tag), std::int64_t{change.remove ? 0 : 1}, operator_name,
        now_unix_ns);
    if (!changed) return fail(changed.error());
  }
  auto after = get_tags_of(db, change.run);
  if (!after) return after;
  if (auto r = transaction->commit(); !r) return fail(r.error());
  return after;
}

Result<std::vector<std::string>> get_tags_of(const Database& db, std::int64_t run) {
  return read_if(has_uuids(db), [&] {
    return db.rows<std::string>("SELECT tag FROM v_tag WHERE run = ? ORDER BY tag", run);
  });
}

Result<std::map<std::int64_t, std::vector<std::string>>> get_tags(const Database& db) {
  std::map<std::int64_t, std::vector<std::string>> out;
  auto known = has_uuids(db);
  if (!known) return fail(known.error());
  if (!*known) return out;
  auto all = db.each("SELECT run, tag FROM v_tag ORDER BY run, tag",
                     [&out](const Statement& s) { out[s.integer(0)].emplace_back(s.text(1)); });
  if (!all) return fail(all.error());
  return out;
}

}  // namespace lcrig
