// SPDX-License-Identifier: Apache-2.0
// Reads a run's stored frame samples in order for FrameTrack. A thread reads ahead in a long run.
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

// Stops at the last sample that was stored when it was opened. The caller may use `db` for other
// queries meanwhile. Short runs are read over `db`, long ones over a connection of their own.
class FrameRows {
 public:
  static Result<FrameRows> open(const Database& db, std::int64_t run);
  // Null: no more rows. The pointer is valid until the next call.
  Result<const FrameRow*> next();

 private:
  using Batch = std::vector<FrameRow>;
  // On the heap, because the thread keeps a pointer to it.
  struct Reader {
    Database own;  // not open when the statement belongs to the caller's connection
    Statement rows;
    Result<Batch> read();
  };
  explicit FrameRows(std::unique_ptr<Reader> reader) : reader_(std::move(reader)) {}
  Result<> fill();

  std::unique_ptr<Reader> reader_;
  bool ahead_ = false, ended_ = false;
  Batch batch_;
  std::size_t next_ = 0;
  std::future<Result<Batch>> coming_;  // declared last: its destructor waits for the thread
};

}  // namespace lcrig
