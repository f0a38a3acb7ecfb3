// SPDX-License-Identifier: Apache-2.0
// The interface between the control socket and the queue. QueueRunner implements it; called on the
// io_context thread. Every change is stored before its task returns.
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
  RunRequest run;  // no operator: the peer
  QueuePlace place;
  QueueTerms terms;
};

// Time and room that an entry will need, as far as they are known.
struct EntryPlan {
  std::optional<double> duration_s;  // nullopt: it could not be planned yet, and `why_not` says why
  std::string why_not;
  std::int64_t measure_readings = 0, bytes = 0;
  double peak_force_N = 0;
  bool moves = true;  // it commands the frame
};

// A table of runs (docs/batch-file.md), with the texts that its cells name.
struct BatchAdd {
  std::string name, file_name;
  std::string table;  // as it was written
  BatchOrder order = BatchOrder::given;
  std::int64_t seed = 0;  // of an order that is drawn
  std::map<std::string, BatchFile> protocols, specimens;  // by the words of the cells
  std::string operator_name;  // none: the peer
  QueuePlace place;
  QueueTerms terms;  // of rows that say nothing else
};
struct BatchAdded {
  std::int64_t first_entry = 0, last_entry = 0, entries = 0;
  double duration_s = 0;  // of those with a plan
  std::int64_t measure_readings = 0, bytes = 0;
  std::int64_t unplanned = 0;
  std::string why_not;  // of those
};

struct QueueAdded {
  std::int64_t entry = 0;
  EntryPlan plan;
};

// Machine time alone, because the time that a person takes is not known.
struct PlannedTime {
  std::optional<std::int64_t> begin_unix_ns, end_unix_ns;  // nullopt: an entry before has no plan
};
struct ListedEntry {
  QueueListing listing;
  EntryPlan plan;
  PlannedTime planned;
  std::optional<EntryBatch> batch;  // it is from; known to `show` alone
};
struct QueuePage {
  std::int64_t count = 0;  // of all that are in the queue
  std::vector<ListedEntry> entries;
};
inline constexpr std::int64_t kQueuePageMax = 500;

class QueueHandler {
 public:
  virtual ~QueueHandler() = default;
  // Checked and planned as far as the rig allows now; what the rig would refuse is refused.
  // Errors: invalid_request, unsupported; busy (locked by somebody else); io (no room on the disk).
  virtual Task<Result<QueueAdded>> add(QueueAdd wanted, PeerCredentials peer) = 0;
  // All of its runs or none. Errors: as `add`; invalid_request with every wrong cell in `detail`.
  virtual Task<Result<BatchAdded>> add_batch(BatchAdd wanted, PeerCredentials peer) = 0;
  virtual Task<Result<QueuePage>> list(std::int64_t skip, std::int64_t most) = 0;
  virtual Task<Result<ListedEntry>> show(std::int64_t entry) = 0;
  virtual Task<Result<std::vector<QueueAct>>> history(std::optional<std::int64_t> entry,
                                                      std::int64_t before, std::int64_t most) = 0;
  // Errors: invalid_request; busy (locked).
  virtual Task<Result<>> move(std::int64_t entry, QueuePlace place, PeerCredentials peer) = 0;
  virtual Task<Result<>> remove(std::int64_t entry, PeerCredentials peer) = 0;
  virtual Task<Result<std::int64_t>> clear(PeerCredentials peer) = 0;
  // The run that goes on is finished, and no other one begins. Everybody who may stop the frame may
  // do this; no lock is in the way.
  virtual Task<Result<>> hold(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<>> start(HeadChoice choice, PeerCredentials peer) = 0;
  virtual Task<Result<>> lock(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<>> unlock(bool force, PeerCredentials peer) = 0;
  // Opens the gate that is shut. `entry`: that somebody saw at the gate. Errors: invalid_request.
  virtual Task<Result<>> answer(std::string text, std::optional<std::int64_t> entry,
                                PeerCredentials peer) = 0;
};

}  // namespace lcrig
