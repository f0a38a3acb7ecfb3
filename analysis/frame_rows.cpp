// SPDX-License-Identifier: Apache-2.0
#include "analysis/frame_rows.hpp"

#include "analysis/pieces.hpp"
#include "storage/database.hpp"

namespace lcrig {

namespace {

// Two batches take 4.8 MB. A quarter of the size was measured to overlap little with the reader.
constexpr std::size_t kBatchRows = 1 << 15;

}  // namespace

Result<FrameRows> FrameRows::open(const Database& db, std::int64_t run) {
  auto last = last_seq(db, "frame_sample", run);
  if (!last) return fail(last.error());
  auto reader = std::make_unique<Reader>();
  const bool ahead = *last > kPieceRows;
  if (ahead) {
    if (auto r = keep(open_read_only(db.path(), db.vfs()), reader->own); !r) return fail(r.error());
  }
  auto rows = (ahead ? reader->own : db)
                  .query(
                      "SELECT received_mono_ns, device_seq, device_time_s, force_N, travel_m, flags"
                      " FROM frame_sample WHERE run_id = ? AND seq <= ? ORDER BY seq",
                      run, *last);
  if (!rows) return fail(rows.error());
  reader->rows = std::move(*rows);
  FrameRows out(std::move(reader));
  out.ahead_ = ahead;
  return out;
}

// Reads one batch. A batch that is not full is the last one.
Result<FrameRows::Batch> FrameRows::Reader::read() {
  Batch out;
  out.reserve(kBatchRows);
  while (out.size() < kBatchRows) {
    auto row = rows.step();
    if (!row) return fail(row.error());
    if (!*row) break;
    FrameRow& r = out.emplace_back();
    r.received_ns = rows.integer(0);
    r.device_seq = rows.integer(1);
    r.device_time_s = rows.optional_real(2);
    r.force_N = rows.optional_real(3);
    r.travel_m = rows.optional_real(4);
    r.flags = rows.integer(5);
  }
  return out;
}

Result<> FrameRows::fill() {
  auto batch = coming_.valid() ? coming_.get() : reader_->read();
  if (!batch) return fail(batch.error());
  batch_ = std::move(*batch);
  next_ = 0;
  ended_ = batch_.size() < kBatchRows;  // stepping again would restart the statement
  if (ahead_ && !ended_) {
    coming_ = std::async(std::launch::async, [reader = reader_.get()] { return reader->read(); });
  }
  return {};
}

Result<const FrameRow*> FrameRows::next() {
  if (next_ == batch_.size() && !ended_) {
    if (auto r = fill(); !r) return fail(r.error());
  }
  const FrameRow* const row = next_ < batch_.size() ? &batch_[next_++] : nullptr;
  return row;
}

}  // namespace lcrig
