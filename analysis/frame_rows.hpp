// SPDX-License-Identifier: Apache-2.0
// The stored samples of a run in order; of a long run, read ahead by a thread.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "storage/sqlite.hpp"

namespace lcrig {

struct FrameRow {
  std::int64_t received_ns = 0, device_seq = 0;
  std::optional<double> device_time_s, force_N, travel_m;
  std::int64_t flags = 0;
};

// Ends at the last sample that was stored when it was opened. `db` may be used for anything else
// meanwhile; short runs are read with it, long ones with a connection of their own.
class FrameRows {
 public:
  static Result<FrameRows> open(const Database& db, std::int64_t run);
  // Null: no more. Valid until the next call.
  Result<const FrameRow*> next();

 private:
  using Batch = std::vector<FrameRow>;
  // At a place of its own: the thread keeps pointing to it.
  struct Reader {
    Database own;  // not open: the statement is the caller's connection's
    Statement rows;
    Result<Batch> read();
  };
  explicit FrameRows(std::unique_ptr<Reader> reader) : reader_(std::move(reader)) {}
  Result<> fill();

  std::unique_ptr<Reader> reader_;
  bool ahead_ = false, ended_ = false;
  Batch batch_;
  std::size_t next_ = 0;
  std::future<Result<Batch>> coming_;  // its destructor waits; before `reader_` goes
};

}  // namespace lcrig
