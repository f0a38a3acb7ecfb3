// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/frame_rescue.hpp"

#include <spdlog/spdlog.h>

#include "base/clock.hpp"
#include "daemon/left_motion.hpp"
#include "daemon/run_words.hpp"
#include "storage/anchor.hpp"
#include "storage/database.hpp"

namespace lcrig {

namespace {

std::string stored_anchor(const Database& db, std::int64_t run) {
  const auto anchor = get_anchor(db, run);
  return anchor && *anchor ? to_string(**anchor) : std::string();  // empty: there is none
}

// Its end was deleted.
bool had_ended(const Database& db, std::int64_t orphan) {
  const auto earlier = get_earlier_anchor(db, orphan);
  return earlier && *earlier;
}

}  // namespace

bool FrameRescue::may_be_left() const {
  constexpr Duration kPatience = std::chrono::seconds(1);  // of a disk
  return rig_.is_real() && may_have_left_motion(database_, kPatience);
}

Task<> FrameRescue::stop_first() {
  spdlog::warn("a run may have been cut off: the frame is stopped before the database is opened");
  stood_first_ = co_await rig_.make_frame_safe();
  if (stood_first_) spdlog::info("the frame confirmed standstill");
}

void FrameRescue::look_at_orphans() {
  for (const auto& orphan : recorder_->interrupted_runs()) {
    const auto db = open_read_only(database_);
    spdlog::warn("{}", orphan_line(orphan, db ? stored_anchor(*db, orphan) : std::string(),
                                   db && had_ended(*db, orphan)));
    const bool commanded = !db || commanded_frame(*db, orphan);
    is_due_ = is_due_ || (rig_.is_real() && commanded);
  }
}

Task<bool> FrameRescue::make_safe() {
  if (!is_due_) co_return true;
  bool stands = stood_first_;
  if (!stands) stands = co_await rig_.make_frame_safe();
  is_due_ = !stands;
  auto interrupted = recorder_->interrupted_runs();
  if (stands) {
    co_await writes_.note(std::move(interrupted),
                          "lcrigd was restarted: the frame confirmed standstill");
  }
  co_return stands;
}

}  // namespace lcrig
