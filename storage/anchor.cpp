// SPDX-License-Identifier: Apache-2.0
#include "storage/anchor.hpp"

#include <algorithm>
#include <charconv>

#include "base/number.hpp"
#include "base/text.hpp"
#include "storage/database.hpp"

namespace lcrig {

namespace {

constexpr std::string_view kAnchorForm =
    "an anchor is the number of links, a colon and 64 hex digits, as the journal, `lcrig run` and "
    "the report show it";

constexpr std::size_t kAnchorShown = 100;  // characters of the user's text in a message

Anchor read_anchor(const Statement& s) {
  Anchor anchor;
  anchor.links = s.integer(0);
  std::ranges::copy(s.blob(1), anchor.hash.begin());
  return anchor;
}

}  // namespace

std::string to_string(const Anchor& anchor) {
  return fmt::format("{}:{}", anchor.links, to_hex(anchor.hash));
}

Result<Anchor> parse_anchor(std::string_view text) {
  const auto wrong = [text](std::string_view why) {
    return fail(Errc::invalid_request, "anchor \"{}\": {}; {}", printable(text, kAnchorShown), why,
                kAnchorForm);
  };
  const auto colon = text.find(':');
  if (colon == text.npos) return wrong("there is no colon");
  const auto links = number_from<std::int64_t>(text.substr(0, colon));
  if (!links || *links < 1) return wrong("the number of links is no number from 1 on");
  const std::string_view digits = text.substr(colon + 1);
  Anchor anchor;
  anchor.links = *links;
  if (digits.size() != 2 * anchor.hash.size()) {
    return wrong(fmt::format("the hash has {} digits", digits.size()));
  }
  for (std::size_t i = 0; i < anchor.hash.size(); ++i) {
    const char* const end = digits.data() + 2 * i + 2;
    if (std::from_chars(end - 2, end, anchor.hash[i], 16).ptr != end) {
      return wrong("the hash has a character that is no hex digit");
    }
  }
  return anchor;
}

Result<std::optional<Anchor>> get_anchor(const Database& db, std::int64_t run) {
  return read_if(has_table(db, "run_anchor"), [&] {
    return db.first("SELECT links, sha256 FROM run_anchor WHERE run_id = ?", read_anchor, run);
  });
}

Result<std::optional<Anchor>> get_earlier_anchor(const Database& db, std::int64_t run) {
  return db.first(
      "SELECT links, sha256 FROM run_anchor WHERE run_id = ?1 AND sha256 <> (SELECT sha256 FROM "
      "chain WHERE run_id = ?1 ORDER BY seq DESC LIMIT 1)",
      read_anchor, run);
}

Result<std::optional<std::int64_t>> find_run_of(const Database& db, const Anchor& anchor) {
  return read_if(has_table(db, "run_anchor"), [&] {
    return db.first<std::int64_t>(
        "SELECT run_id FROM run_anchor WHERE links = ? AND lower(hex(sha256)) = ?", anchor.links,
        to_hex(anchor.hash));
  });
}

}  // namespace lcrig
