// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/plans.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "drivers/reopening.hpp"
#include "protocols/plan/plan.hpp"
#include "storage/row_hash.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kMostPlans = 1000;

// Everything that a plan depends on, except the rig.
std::string key_of(const RunRequest& run) {
  const auto parameters = to_json(run)["parameters"].dump();
  return sha256_hex(run.protocol_text) + sha256_hex(parameters) + sha256_hex(run.specimen_text);
}

Result<> compare_or_keep(std::optional<Identity>& known, const Identity& now) {
  if (known) return compare_identity(*known, now);
  known = now;
  return {};
}

}  // namespace

Result<> KnownIdentities::compare(const Identity& meter, const Identity& frame, bool rod) {
  if (auto same = compare_or_keep(meter_, meter); !same) return same;
  return compare_or_keep(rod ? rod_ : frame_, frame);
}

// Removes the facts about the specimen, which may not be on the rig any more.
void QueuePlans::see(Rig rig, bool with_weights) {
  rig.compression_m = {};
  rig.specimen_least_m = rig.specimen_free_m = {};
  rig.pressure.disc_diameter_m.reset();
  rig.pressure.plate = false;
  (with_weights ? rod_ : frame_) = std::move(rig);
}

std::optional<EntryPlan> QueuePlans::find(const RunRequest& run) const {
  const auto found = plans_.find(key_of(run));
  if (found == plans_.end()) return std::nullopt;
  return found->second;
}

void QueuePlans::keep(const RunRequest& run, const EntryPlan& plan) {
  if (plans_.size() >= kMostPlans) plans_.clear();
  plans_[key_of(run)] = plan;
}

EntryPlan entry_plan(const Plan& plan, bool moves) {
  EntryPlan out;
  out.duration_s = plan.duration_s;
  out.measure_readings = plan.measure_readings;
  out.bytes = plan.bytes;
  out.peak_force_N = plan.peak_force_N;
  out.moves = moves;
  out.pressure = plan.pressure.words();
  return out;
}

bool is_no_refusal(Errc code) {
  switch (code) {
    case Errc::no_reply:
    case Errc::reply_cut_off:
    case Errc::garbled:
    case Errc::disconnected:
    case Errc::busy:
    case Errc::io:
    case Errc::not_standing:
    case Errc::frame_fault: return true;
    default: return false;
  }
}

}  // namespace lcrig
