// SPDX-License-Identifier: Apache-2.0
// Runs the queued entries: reads the stored queue, asks decide.hpp what to do, does it, and stores
// the result. It relies only on what it reads from the database. Owned by App.
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
  // `clock` and `host` must outlive it.
  QueueRunner(asio::any_io_executor executor, Clock& clock, QueueHost& host, std::string database,
              std::string vfs);

  // Settles what a crash left, before clients can ask. True: the queue was going then.
  Result<bool> open(const Database& db);
  // Runs until `end`.
  Task<> run();
  // Lets no other entry begin. `run` returns once the end of the current entry is stored.
  void end();
  bool over() const { return over_; }

  // Call after a change that may let an entry begin.
  void wake();
  // The queue is started: an entry runs, or will when a gate opens.
  bool goes() const { return status_.going; }
  const QueueStatus& status() const { return status_; }
  // A gate waits only for consent to a motion.
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
  // The part of the stored queue that decides what is next.
  struct Look {
    QueueState state;
    std::int64_t count = 0;
    std::optional<QueueListing> head;
    std::optional<std::int64_t> last_end_unix_ns;  // of any run
  };
  static Result<Look> look_at(const Database& db);
  QueueFacts facts_of(const Look& look) const;
  Task<> step();
  // Decides the next act and updates the status.
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
  // Whether nobody else has locked the queue and the disk has room for all waiting runs and for
  // `bytes` more.
  Result<> may_add(const Database& db, const QueueActor& who, std::int64_t bytes) const;
  // Changes the queue unless somebody else locked it. Call `tell_change` afterwards.
  template <class Job>
  Task<Result<>> change(Job job, PeerCredentials peer);
  // Updates the status before the client that made the change gets its answer, also during a run.
  Task<> tell_change();

  Clock& clock_;
  QueueHost& host_;
  QueueStore store_;
  Condition changed_;
  std::uint64_t wakes_ = 0;
  QueueStatus status_;
  std::optional<Gate> gate_;  // the closed gate
  std::optional<MonoTime> person_seen_;  // when a person last acted, if no run has begun since
  // Probe and fixture on the rig, as a person named them; unknown after a restart.
  std::optional<std::string> probe_, fixture_;
  // The entry whose specimen does not show the expected capacitance, and the entry that a person
  // approved nevertheless.
  std::optional<std::pair<std::int64_t, std::string>> stranger_;
  std::int64_t vouched_ = 0;
  std::optional<std::int64_t>
      waiting_offset_ns_;  // wall clock minus our clock, during a wait for a time
  bool answering_ = false;  // an answer at a gate is being stored
  bool ending_ = false, over_ = false;
};

}  // namespace lcrig
