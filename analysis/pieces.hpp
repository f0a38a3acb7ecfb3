// SPDX-License-Identifier: Apache-2.0
// Works on the rows of a long run in pieces, with several threads that have a connection each. Used
// for reading a run, for the fit of the device's clock and for the export.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "storage/sqlite.hpp"

namespace lcrig {

struct Piece {
  std::int64_t first_seq = 0, last_seq = 0;  // inclusive on both sides
};

// Rows of a piece. As text they are some megabytes and take a few hundredths of a second.
constexpr std::int64_t kPieceRows = 1 << 16;

// The last `seq` of `run` in `table` as `db` sees it now; 0: there is none. Stored rows never
// change, so a reader that stops there sees the same rows over any connection.
Result<std::int64_t> last_seq(const Database& db, std::string_view table, std::int64_t run);

// `make` turns each piece of 1..last_seq into a text. It runs on any thread, with a connection that
// nobody else uses at the time. `use` takes the texts in order on the calling thread. At most two
// more pieces than threads are in memory. A single piece is made on the calling thread over `db`.
using MakePiece = std::function<Result<std::string>(const Database&, Piece)>;
using UsePiece = std::function<Result<>(const std::string&)>;
Result<> in_pieces(const Database& db, std::int64_t last_seq, std::int64_t piece_rows,
                   const MakePiece& make, const UsePiece& use);

}  // namespace lcrig
