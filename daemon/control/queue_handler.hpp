// SPDX-License-Identifier: Apache-2.0
// The interface between the control socket and the queue. QueueRunner implements it. It is called
// on the io_context thread. Every change is stored before its task returns.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "daemon/control/messages.hpp"
#include "daemon/queue/terms.hpp"
#include "protocols/batch/batch.hpp"
#include "storage/batches.hpp"
#include "storage/queue_run.hpp"

namespace lcrig {

struct QueueAdd {
  RunRequest run;  // without an operator: the peer
  QueuePlace place;
  QueueTerms terms;
};

// Time and disk space that an entry will need, as far as known.
struct EntryPlan {
  std::optional<double> duration_s;  // nullopt: no plan was possible yet, for the reason `why_not`
  std::string why_not;
  std::int64_t measure_readings = 0, bytes = 0;
  double peak_force_N = 0;
  bool moves = true;  // whether it commands the frame
  std::string pressure;  // PressureArea::words(): empty where probe and disc agree
};

// A table of runs (docs/batch-file.md), with the texts that its cells name.
struct BatchAdd {
  std::string name, file_name;
  std::string table;  // as written
  BatchOrder order = BatchOrder::given;
  std::int64_t seed = 0;  // for an order drawn at random
  std::map<std::string, BatchFile> protocols, specimens;  // by the words in the cells
  std::string operator_name;  // empty: the peer
  QueuePlace place;
  QueueTerms terms;  // defaults for all rows
};
struct BatchAdded {
  std::int64_t first_entry = 0, last_entry = 0, entries = 0;
  double duration_s = 0;  // sum over the entries with a plan
  std::int64_t measure_readings = 0, bytes = 0;
  std::int64_t unplanned = 0;
  std::string why_not;  // why some entries have no plan
  std::vector<std::string> pressures;  // EntryPlan::pressure, each once
};

struct QueueAdded {
  std::int64_t entry = 0;
  EntryPlan plan;
};

// Times of the machine alone, because nobody knows how long people will take.
struct PlannedTime {
  std::optional<std::int64_t> begin_unix_ns, end_unix_ns;  // nullopt: an earlier entry has no plan
};
struct ListedEntry {
  QueueListing listing;
  EntryPlan plan;
  PlannedTime planned;
  std::optional<EntryBatch> batch;  // the batch it belongs to; filled in by `show` only
};
struct QueuePage {
  std::int64_t count = 0;  // number of all entries in the queue
  std::vector<ListedEntry> entries;
};
inline constexpr std::int64_t kQueuePageMax = 500;

class QueueHandler {
 public:
  virtual ~QueueHandler() = default;
  // Adds an entry after checking and planning it as far as the rig allows now. Refuses whatever the
  // rig would refuse. Errors: invalid_request, unsupported; busy (locked by somebody else); io (no
  // room on the disk).
  virtual Task<Result<QueueAdded>> add(QueueAdd wanted, PeerCredentials peer) = 0;
  // Adds all runs of a batch or none. Errors: as `add`; invalid_request with every wrong cell in
  // `detail`.
  virtual Task<Result<BatchAdded>> add_batch(BatchAdd wanted, PeerCredentials peer) = 0;
  virtual Task<Result<QueuePage>> list(std::int64_t skip, std::int64_t most) = 0;
  virtual Task<Result<ListedEntry>> show(std::int64_t entry) = 0;
  virtual Task<Result<std::vector<QueueAct>>> history(std::optional<std::int64_t> entry,
                                                      std::int64_t before, std::int64_t most) = 0;
  // Errors of these: invalid_request; busy (locked).
  virtual Task<Result<>> move(std::int64_t entry, QueuePlace place, PeerCredentials peer) = 0;
  virtual Task<Result<>> remove(std::int64_t entry, PeerCredentials peer) = 0;
  virtual Task<Result<std::int64_t>> clear(PeerCredentials peer) = 0;
  // The current run is finished, and no other one begins. Everybody who may stop the frame may do
  // this, even if the queue is locked.
  virtual Task<Result<>> hold(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<>> start(HeadChoice choice, PeerCredentials peer) = 0;
  virtual Task<Result<>> lock(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<>> unlock(bool force, PeerCredentials peer) = 0;
  // Opens the closed gate. `entry`: the entry that the user saw at the gate. Errors:
  // invalid_request.
  virtual Task<Result<>> answer(std::string text, std::optional<std::int64_t> entry,
                                PeerCredentials peer) = 0;
};

}  // namespace lcrig
