// SPDX-License-Identifier: Apache-2.0
#include "analysis/pieces.hpp"

#include <algorithm>
#include <deque>
#include <future>
#include <thread>
#include <vector>

#include "storage/database.hpp"

namespace lcrig {

namespace {

// More threads would only wait for the disk and for the writing of the result.
constexpr unsigned kMostThreads = 4;

}  // namespace

Result<std::int64_t> last_seq(const Database& db, std::string_view table, std::int64_t run) {
  auto last = db.first(
      fmt::format("SELECT max(seq) FROM {} WHERE run_id = ?", table),
      [](const Statement& row) { return row.optional_integer(0).value_or(0); }, run);
  if (!last) return fail(last.error());
  return last->value_or(0);
}

Result<> in_pieces(const Database& db, std::int64_t last_seq, std::int64_t piece_rows,
                   const MakePiece& make, const UsePiece& use) {
  const std::int64_t count = (last_seq + piece_rows - 1) / piece_rows;
  if (count <= 1) {
    auto text = make(db, {1, last_seq});
    return text ? use(*text) : fail(text.error());
  }
  const std::int64_t threads = std::min<std::int64_t>(
      count, std::clamp(std::thread::hardware_concurrency(), 1U, kMostThreads));
  std::vector<Database> connections;
  for (std::int64_t i = 0; i < threads; ++i) {
    auto connection = open_read_only(db.path(), db.vfs());
    if (!connection) return fail(connection.error());
    connections.push_back(std::move(*connection));
  }
  // A connection serves every `threads`-th piece. It is free again once its last piece was taken.
  std::deque<std::future<Result<std::string>>> coming;
  const auto start = [&](std::int64_t k) {
    const Piece piece{k * piece_rows + 1, std::min(last_seq, (k + 1) * piece_rows)};
    const Database& connection = connections[static_cast<std::size_t>(k % threads)];
    coming.push_back(std::async(std::launch::async,
                                [&make, &connection, piece] { return make(connection, piece); }));
  };
  for (std::int64_t k = 0; k < threads; ++k) start(k);
  for (std::int64_t k = 0; k < count; ++k) {
    const auto text = coming.front().get();
    coming.pop_front();
    if (!text) return fail(text.error());
    if (k + threads < count) start(k + threads);
    if (auto r = use(*text); !r) return r;
  }
  return {};
}

}  // namespace lcrig
