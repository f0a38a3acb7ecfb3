// SPDX-License-Identifier: Apache-2.0
// Works on the rows of a long run in pieces, by threads that have a connection each. Reading a run,
// the fit of the device's clock and the export use it.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "storage/sqlite.hpp"

namespace lcrig {

struct Piece {
  std::int64_t first_seq = 0, last_seq = 0;  // both belong to it
};

// Rows of a piece: some megabytes as text, and a few hundredths of a second of work.
constexpr std::int64_t kPieceRows = 1 << 16;

// The last `seq` of `run` in `table` as `db` sees it now; 0: none. Stored rows never change, so a
// reader that stops there sees the same rows on any connection.
Result<std::int64_t> last_seq(const Database& db, std::string_view table, std::int64_t run);

// `make` turns each of the pieces of 1..last_seq into a text, on any thread and with a connection
// that nobody else uses meanwhile; `use` takes the texts on the calling thread, in order. At most
// two more pieces than threads are kept. With one piece, `make` runs here and on `db`.
using MakePiece = std::function<Result<std::string>(const Database&, Piece)>;
using UsePiece = std::function<Result<>(const std::string&)>;
Result<> in_pieces(const Database& db, std::int64_t last_seq, std::int64_t piece_rows,
                   const MakePiece& make, const UsePiece& use);

}  // namespace lcrig
