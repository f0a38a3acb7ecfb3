// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/database_writes.hpp"

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "base/aside.hpp"
#include "base/text.hpp"
#include "daemon/app/callers.hpp"
#include "daemon/control/audit.hpp"
#include "model/plausible.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/specimens.hpp"
#include "storage/tags.hpp"

namespace lcrig {

namespace {

tl::unexpected<Error> is_storing() {
  return fail(Errc::busy, "another note or specimen is being stored: try again");
}

// Changes the database. Not to be called on the thread of the instruments.
template <class Change>
auto write_to(const std::string& database, Change change)
    -> std::invoke_result_t<Change&, const Database&> {
  auto db = open_read_write(database);
  if (!db) return fail(db.error());
  return change(*db);
}

}  // namespace

template <class Job>
Task<std::invoke_result_t<Job&>> DatabaseWrites::store(Job job) {
  auto stored = co_await run_aside(executor_, clock_, std::move(job));
  storing_ = false;
  co_return stored;
}

Task<Result<>> DatabaseWrites::note_run(std::int64_t run, std::string text, PeerCredentials peer) {
  if (storing_) co_return is_storing();
  storing_ = true;
  peer.user = co_await callers_.name_of(peer);
  const std::int64_t now = clock_.unix_ns();
  const auto add = [&](const Database& db) { return add_run_note(db, run, peer.user, text, now); };
  const auto job = [&] { return write_to(database_, add); };
  auto noted = co_await store(job);
  if (noted) spdlog::info("a note was added to run {} for {}", run, peer_words(peer));
  co_return noted;
}

Task<Result<std::vector<std::string>>> DatabaseWrites::tag_run(TagRequest request,
                                                               PeerCredentials peer) {
  if (storing_) co_return is_storing();
  storing_ = true;
  peer.user = co_await callers_.name_of(peer);
  TagChange change;
  change.run = request.run;
  change.tags = std::move(request.tags);
  change.remove = request.remove;
  const std::int64_t now = clock_.unix_ns();
  const auto put = [&](const Database& db) { return change_tags(db, change, peer.user, now); };
  const auto job = [&] { return write_to(database_, put); };
  auto tags = co_await store(job);
  if (tags) {
    spdlog::info("run {}: {} {} for {}", change.run, fmt::join(change.tags, ", "),
                 change.remove ? "was taken off" : "was put on it", peer_words(peer));
  }
  co_return tags;
}

Task<Result<std::string>> DatabaseWrites::add_specimen(SpecimenToAdd wanted, PeerCredentials peer) {
  if (storing_) co_return is_storing();
  storing_ = true;
  const std::int64_t now = clock_.unix_ns();
  const auto job = [this, &wanted, now]() -> Result<std::string> {
    auto specimen = accept_specimen(wanted.text, "specimen");
    if (!specimen) return fail(specimen.error());
    const auto odd = wanted.as_stated ? std::vector<std::string>() : implausible_values(*specimen);
    if (!odd.empty()) {
      return fail(Errc::invalid_request, "{}; \"as_stated\": true stores it all the same",
                  fmt::join(odd, "; "));
    }
    const auto add = [&](const Database& db) {
      return lcrig::add_specimen(db, specimen->name, wanted.text, now);
    };
    auto stored = write_to(database_, add);
    if (!stored) return fail(stored.error());
    return specimen->name;
  };
  auto name = co_await store(job);
  peer.user = co_await callers_.name_of(peer);
  if (name) spdlog::info("specimen {} stored for {}", printable(*name), peer_words(peer));
  co_return name;
}

Task<> DatabaseWrites::note(std::vector<std::int64_t> runs, std::string text) {
  if (runs.empty()) co_return;
  for (const std::int64_t run : runs) spdlog::info("run {}: {}", run, text);
  const std::int64_t now = clock_.unix_ns();
  const auto add = [&](const Database& db) -> Result<> {
    Result<> all;
    for (const std::int64_t run : runs) {
      if (auto noted = add_run_note(db, run, "lcrigd", text, now); !noted) all = noted;
    }
    return all;
  };
  const auto job = [&] { return write_to(database_, add); };
  auto noted = co_await run_aside(executor_, clock_, job);
  if (!noted) spdlog::warn("{}", printable(noted.error().what));
}

}  // namespace lcrig
