// SPDX-License-Identifier: Apache-2.0
// Collects the rows of one run for the database, and stores them. Used by the recorder.
#pragma once

#include <optional>
#include <vector>

#include "protocols/run/sink.hpp"
#include "storage/chain.hpp"
#include "storage/runs.hpp"

namespace lcrig {

struct Batch {
  struct TaggedReading {
    LcrReading reading;
    ReadingTag tag;
  };
  std::vector<LoadLevel> levels;
  std::vector<RunEvent> events;
  std::vector<TaggedReading> readings;
  std::vector<FrameSample> samples;
  std::optional<MonoTime> oldest;  // when the first row was queued, by the real clock

  std::size_t rows() const {
    return levels.size() + events.size() + readings.size() + samples.size();
  }
  void clear();  // keeps the memory
};

// Stores batches, each in one transaction with one link of the hash chain. To be used on one
// thread.
class BatchWriter {
 public:
  static Result<BatchWriter> prepare(const Database& db);
  // Stores all of `batch`, and the run's end if given; after an error, nothing. Repeating it with
  // the same rows never stores them twice, even if the failed COMMIT had reached the disk.
  Result<> write(const Database& db, std::int64_t run, const Batch& batch, const RunEnd* end);
  // The link whose COMMIT failed. Pass it to the writer of a reopened connection.
  const std::optional<Sha256>& failed_attempt() const { return failed_attempt_; }
  void set_failed_attempt(std::optional<Sha256> hash) { failed_attempt_ = hash; }

 private:
  Result<> write_rows(std::int64_t run, const Batch& batch, ChainHead& head);
  Result<> write_level(std::int64_t run, std::int64_t seq, const LoadLevel& level);
  Result<> write_event(std::int64_t run, std::int64_t seq, const RunEvent& event);
  Result<> write_reading(std::int64_t run, std::int64_t seq, const Batch::TaggedReading& row);
  Result<> write_sample(std::int64_t run, std::int64_t seq, const FrameSample& sample);
  Result<> write_end(std::int64_t run, const RunEnd& end);

  std::optional<RowWriter> levels_, events_, readings_, samples_, ends_;
  std::optional<ChainWriter> chain_;
  RowHash hash_;
  std::optional<Sha256> failed_attempt_;
};

}  // namespace lcrig
