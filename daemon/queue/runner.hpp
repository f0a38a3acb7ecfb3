// SPDX-License-Identifier: Apache-2.0
// Runs the queued entries: looks at the stored queue, asks decide.hpp what to do, does it, and
// stores the result. It knows only what it has read from the database. App owns it.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "base/condition.hpp"
#include "daemon/queue/decide.hpp"
#include "daemon/queue/host.hpp"
#include "daemon/queue/store.hpp"

namespace lcrig {

struct WantedBatch;

class QueueRunner final : public QueueHandler {
 public:
  // `clock` and `host` outlive it.
  QueueRunner(asio::any_io_executor executor, Clock& clock, QueueHost& host, std::string database,
              std::string vfs);

  // Settles what a crash left, before anybody can ask. True: it was going then.
  Result<bool> open(const Database& db);
  // Until `end`.
  Task<> run();
  // No other entry begins. `run` returns once the one that runs is stored as ended.
  void end();
  bool over() const { return over_; }

  // Something changed that may let an entry begin.
  void wake();
  // Its turn is now, or comes as soon as a gate opens.
  bool goes() const { return status_.going; }
  const QueueStatus& status() const { return status_; }
  // A gate waits for consent to a motion, and for nothing else.
  bool awaits_consent() const { return gate_ && gate_->kind == QueueGate::person; }

  Task<Result<QueueAdded>> add(QueueAdd wanted, PeerCredentials peer) override;
  Task<Result<BatchAdded>> add_batch(BatchAdd wanted, PeerCredentials peer) override;
  Task<Result<QueuePage>> list(std::int64_t skip, std::int64_t most) override;
  Task<Result<ListedEntry>> show(std::int64_t entry) override;
  Task<Result<std::vector<QueueAct>>> history(std::optional<std::int64_t> entry,
                                              std::int64_t before, std::int64_t most) override;
  Task<Result<>> move(std::int64_t entry, QueuePlace place, PeerCredentials peer) override;
  Task<Result<>> remove(std::int64_t entry, PeerCredentials peer) override;
  Task<Result<std::int64_t>> clear(PeerCredentials peer) override;
  Task<Result<>> hold(std::string why, PeerCredentials peer) override;
  Task<Result<>> start(HeadChoice choice, PeerCredentials peer) override;
  Task<Result<>> lock(std::string why, PeerCredentials peer) override;
  Task<Result<>> unlock(bool force, PeerCredentials peer) override;
  Task<Result<>> answer(std::string text, std::optional<std::int64_t> entry,
                        PeerCredentials peer) override;

 private:
  // The stored queue, as far as it decides what is next.
  struct Look {
    QueueState state;
    std::int64_t count = 0;
    std::optional<QueueListing> head;
    std::optional<std::int64_t> last_end_unix_ns;  // of a run of anybody
  };
  static Result<Look> look_at(const Database& db);
  QueueFacts facts_of(const Look& look) const;
  Task<> step();
  // Finds the next act and updates the status.
  Task<Result<NextAct>> look();
  void show_look(const Look& look, const NextAct& next);
  Task<> wait_for_change(std::uint64_t seen, Duration patience);
  Task<> take_turn(std::int64_t entry);
  Task<Result<TurnOfQueue>> turn_of(std::int64_t entry);
  Task<> store_end(std::int64_t entry, TurnEnd end);
  Task<> finish();
  Task<> hold_by_itself(HoldCause cause, std::string why);
  // How far somebody set the clock while an entry waited for a time.
  std::optional<double> clock_step_s(const NextAct& next);
  Task<> refuse_late(TooLate late);
  Task<Result<>> plan_batch(WantedBatch& batch);
  Task<Result<>> store_answer(Gate gate, PeerCredentials peer);
  Task<QueueActor> actor(PeerCredentials peer);
  // Nobody else locked it, and the disk has room for what waits and for so much more.
  Result<> may_add(const Database& db, const QueueActor& who, std::int64_t bytes) const;
  // Changes the queue unless somebody else locked it. `tell_change` follows.
  template <class Job>
  Task<Result<>> change(Job job, PeerCredentials peer);
  // The status is that of after a change before its client has the answer, also in a run.
  Task<> tell_change();

  Clock& clock_;
  QueueHost& host_;
  QueueStore store_;
  Condition changed_;
  std::uint64_t wakes_ = 0;
  QueueStatus status_;
  std::optional<Gate> gate_;  // that is shut
  std::optional<MonoTime> person_seen_;  // acted then, and no turn began since
  // Probe and fixture on the rig, as a person named them; forgotten by a restart.
  std::optional<std::string> probe_, fixture_;
  // The entry whose specimen does not show what it should, and the one that a person vouched for.
  std::optional<std::pair<std::int64_t, std::string>> stranger_;
  std::int64_t vouched_ = 0;
  std::optional<std::int64_t>
      waiting_offset_ns_;  // wall clock minus ours, while a time is waited for
  bool answering_ = false;  // the answer to a gate is being stored
  bool ending_ = false, over_ = false;
};

}  // namespace lcrig
