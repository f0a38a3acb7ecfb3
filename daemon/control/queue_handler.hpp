// SPDX-License-Identifier: Apache-2.0
// What clients of the control socket ask of the queue. QueueRunner implements it; called on the
// io_context thread. Every change is stored before its task returns.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "daemon/control/messages.hpp"
#include "daemon/queue/terms.hpp"
#include "storage/queue_run.hpp"

namespace lcrig {

struct QueueAdd {
  RunRequest run;  // no operator: the peer
  QueuePlace place;
  QueueTerms terms;
};

// What an entry will take, as far as it is known.
struct EntryPlan {
  std::optional<double> duration_s;  // nullopt: it could not be planned yet, and `why_not` says why
  std::string why_not;
  std::int64_t measure_readings = 0, bytes = 0;
  double peak_force_N = 0;
  bool moves = true;  // it commands the frame
};

struct QueueAdded {
  std::int64_t entry = 0;
  EntryPlan plan;
};

// Machine time alone: nobody knows how long a person takes.
struct PlannedTime {
  std::optional<std::int64_t> begin_unix_ns, end_unix_ns;  // nullopt: an entry before has no plan
};
struct ListedEntry {
  QueueListing listing;
  EntryPlan plan;
  PlannedTime planned;
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
  virtual Task<Result<QueuePage>> list(std::int64_t skip, std::int64_t most) = 0;
  virtual Task<Result<ListedEntry>> show(std::int64_t entry) = 0;
  virtual Task<Result<std::vector<QueueAct>>> history(std::optional<std::int64_t> entry,
                                                      std::int64_t before, std::int64_t most) = 0;
  // Errors: invalid_request; busy (locked).
  virtual Task<Result<>> move(std::int64_t entry, QueuePlace place, PeerCredentials peer) = 0;
  virtual Task<Result<>> remove(std::int64_t entry, PeerCredentials peer) = 0;
  virtual Task<Result<std::int64_t>> clear(PeerCredentials peer) = 0;
  // The run that goes on is finished, and no other one begins. Whoever may stop the frame may do
  // this; no lock is in the way.
  virtual Task<Result<>> hold(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<>> start(HeadChoice choice, PeerCredentials peer) = 0;
  virtual Task<Result<>> lock(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<>> unlock(bool force, PeerCredentials peer) = 0;
  // Opens the gate that is shut. `entry`: that somebody saw at the gate. Errors: invalid_request.
  virtual Task<Result<>> answer(std::string text, std::optional<std::int64_t> entry,
                                PeerCredentials peer) = 0;
};

}  // namespace lcrig
