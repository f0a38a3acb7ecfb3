// SPDX-License-Identifier: Apache-2.0
#include "tests/property/contradiction.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace lcrig::property {

namespace {

using Seen = RigWitness::Seen;
using Word = RigWitness::Word;

// Samples come in batches of 0.1 s, up to 0.1 s apart, and it may take two to notice something.
constexpr Duration kAllowance = std::chrono::milliseconds(300);
// DONE is believed if the samples after it agree. A lost zero is noticed within a second.
constexpr Duration kAfterDone = std::chrono::milliseconds(550);
// share of the printed time; a lie may also be noticed this early
constexpr double kQuicker = 0.45;
constexpr double kDigitsUnseen_m = 36e-6;  // three of the coarsest digits of a travel
constexpr Duration kZeroTime = std::chrono::milliseconds(1500);

// Examines one lie and its window sample by sample.
class Look {
 public:
  Look(const Trial& t, const PrintedWatch& p, std::size_t lie)
      : world_(t.world()),
        rig_(t.rig()),
        watch_(p),
        lie_(t.what().lies[lie]),
        seen_(world_.witness.seen),
        orders_(ordered_motions(world_.witness)) {
    const Trial::Told& told = t.told()[lie];
    from_ = told.from.value_or(MonoTime::max());
    to_ = told.to.value_or(MonoTime::max());
    digits_N_ = 8 * rig_.plant.force_noise_N + 2 * rig_.plant.force_resolution_N;
  }

  std::optional<Contradiction> find() {
    using enum FrameLie;
    if (from_ == MonoTime::max()) return std::nullopt;
    switch (lie_.what) {
      case force_frozen: return frozen();
      case force_held:
      case force_gain: return did_not_follow();
      case force_reversed: return fell();
      case tare_lost: return lost_zero();
      case stall:
      case done_late: return stood_still();
      case drive_reversed: return went_back();
      case creep: return moved_unasked();
      case order_late: return earlier(stood_still(), moved_unasked());
      case done_early:
      case done_unmoved: return was_not_there();
      case estop: return told_of_fault();
      default: return std::nullopt;
    }
  }

 private:
  using Found = std::optional<Contradiction>;

  static Found earlier(Found a, Found b) {
    if (!a || !b) return a ? a : b;
    return a->due <= b->due ? a : b;
  }
  Contradiction at(const Seen& first, MonoTime shown, const Ordered* order) const {
    Contradiction c;
    c.taken = first.taken;
    c.first = *first.arrived;
    c.due = shown + from_seconds(watch_.reply_s) + kAllowance;
    c.true_N = first.true_N;
    if (order != nullptr) c.speed_m_s = order->speed_m_s, c.rate_N_s = order->rate_N_s;
    return c;
  }
  // Samples that the daemon received while this motion was under way and the lie lasted.
  template <class F>
  void each(const Ordered& o, F f) const {
    const MonoTime begin = std::max(from_, o.sent), end = std::min(to_, o.over);
    for (const Seen& s : seen_) {
      if (s.taken > end) break;
      if (s.taken >= begin && s.arrived && *s.arrived <= o.over) f(s);
    }
  }

  // Finds samples in which a value stays the same for `long_s`, or for a shorter time that ended
  // with STOP.
  template <class Same>
  Found unchanged(double long_s, Same same) const {
    for (const Ordered& o : orders_) {
      const Seen *first = nullptr, *last = nullptr;
      Found found;
      each(o, [&](const Seen& s) {
        if (found) return;
        const int verdict = first == nullptr ? 0 : same(o, *first, s);
        if (verdict <= 0) first = verdict == 0 ? &s : first;
        const double needed_s = long_s * patience(o);
        if (first == nullptr) return;
        last = &s;
        if (*s.arrived >= *first->arrived + from_seconds(needed_s)) {
          found = at(*first, *s.arrived, &o);
        }
      });
      const Duration half = from_seconds(kQuicker * long_s);
      if (!found && o.is_stopped && last != nullptr && *last->arrived >= *first->arrived + half) {
        found = at(*first, *first->arrived + from_seconds(long_s * patience(o)), &o);
      }
      if (found && found->due < o.over) return found;
      if (found && stopped_within(*found)) return found;
    }
    return std::nullopt;
  }
  // Factor on the time, for missing samples and for speeds at which a visible distance takes
  // longer.
  double patience(const Ordered& o) const {
    const double missing = std::max(rig_.frame.missing_force, rig_.frame.missing_travel);
    // at most every twentieth is missing, but they may cluster
    const double there = missing > 0 ? 1.2 : 1;
    if (lie_.what == FrameLie::force_frozen || o.speed_m_s <= 0) return there;
    double way_m = std::max(2 * watch_.against_m, 4 * rig_.plant.travel_resolution_m);
    // No motion has shown yet how coarse the travel is.
    if (o.sent == orders_.front().sent) way_m = std::max(way_m, kDigitsUnseen_m);
    return there * std::max(1.0, way_m / o.speed_m_s / watch_.stall_s);
  }
  bool stopped_within(const Contradiction& c) const {
    return std::ranges::any_of(stops_sent(world_.witness),
                               [&](MonoTime s) { return s >= c.taken && s <= c.due; });
  }

  // 1: the same, 0: another one, -1: nothing to compare.
  Found frozen() const {
    if (!watch_.frozen_force_s) return std::nullopt;
    return unchanged(*watch_.frozen_force_s, [](const Ordered&, const Seen& a, const Seen& b) {
      if (!a.shown.force_N) return 0;
      if (!b.shown.force_N) return -1;
      return *a.shown.force_N == *b.shown.force_N ? 1 : 0;
    });
  }
  // RAMPF is left out, because a force loop may have nothing to do.
  Found stood_still() const {
    return unchanged(2 * watch_.stall_s, [](const Ordered& o, const Seen& a, const Seen& b) {
      if (o.word == "RAMPF" || !a.shown.travel_m) return 0;
      if (!b.shown.travel_m) return -1;
      return a.true_m == b.true_m ? 1 : 0;
    });
  }

  Found went_back() const {
    for (const Ordered& o : orders_) {
      if (o.direction == 0) continue;
      double best = -1e9;
      Found found;
      each(o, [&](const Seen& s) {
        if (!s.shown.travel_m || found) return;
        const double way = o.direction * *s.shown.travel_m;
        best = std::max(best, way);
        const double back = best - way;
        if (back > watch_.against_m + 2 * rig_.plant.travel_resolution_m) {
          found = at(s, *s.arrived, &o);
        }
      });
      if (found) return found;
    }
    return std::nullopt;
  }

  // In a motion towards the specimen, the force shown falls by more than a specimen relaxes.
  Found fell() const {
    for (const Ordered& o : orders_) {
      if (o.direction <= 0) continue;
      const Seen* before = nullptr;
      for (const Seen& s : seen_) {
        if (s.taken <= o.sent && s.shown.force_N) before = &s;
      }
      if (before == nullptr) continue;
      const double begun = *before->shown.force_N;
      const double doubt_N = 0.003 * rig_.plant.force_nominal_N + 0.05 * rig_.limit_N;
      const double allowed_N = doubt_N + 0.4 * std::abs(before->true_N) + 2 * digits_N_;
      Found found;
      const Seen* last = nullptr;
      each(o, [&](const Seen& s) {
        if (!s.shown.force_N || found) return;
        const double fallen = begun - *s.shown.force_N;
        if (fallen > allowed_N) found = at(s, *s.arrived, &o);
        if (fallen > 2 * digits_N_) last = &s;
      });
      if (!found && last != nullptr && (o.is_stopped || o.is_limited)) {
        found = at(*last, o.over, &o);
      }
      // The device has already stopped by itself, and the run may examine what it felt while it
      // goes back.
      if (found && o.is_limited) found->due = world_.over_at;
      if (found) return found;
    }
    return std::nullopt;
  }

  // In a motion deeper than any before, the force shown rises by less than 1/25 of the stiffness
  // measured at contact. Or it is less than 70 % of the true force, and something stopped the
  // motion.
  Found did_not_follow() const {
    for (const Ordered& o : orders_) {
      const auto contact = printed_contact(world_, o.sent);
      if (o.direction <= 0 || !contact) continue;
      const double from_m = std::max(contact->travel_m, deepest_m(seen_, o.sent)) + 2e-6 +
                            2 * rig_.plant.travel_resolution_m;
      const double begun_N = shown_N(seen_, o.sent);
      const double doubt_N = 1.5 * watch_.order_force_N + digits_N_ +
                             0.002 * rig_.plant.force_nominal_N + 0.35 * std::abs(begun_N);
      int so_far = 0;
      Found found;
      const Seen* last = nullptr;
      each(o, [&](const Seen& s) {
        if (!s.shown.force_N || !s.shown.travel_m || found) return;
        const double k = contact->stiffness_N_m, felt_N = std::abs(*s.shown.force_N);
        const double creeps_m = 0.02 * felt_N / k * to_seconds(s.taken - o.sent);
        const double pressed_N = 0.04 * k * (*s.shown.travel_m - from_m - creeps_m);
        const bool follows = *s.shown.force_N >= pressed_N + begun_N - doubt_N;
        so_far = follows ? 0 : so_far + 1;
        if (so_far == 3) found = at(s, *s.arrived, &o);
        if (*s.shown.force_N < 0.7 * s.true_N - 2 * watch_.order_force_N - digits_N_) last = &s;
      });
      // The run noticed it earlier than that.
      if (!found && o.is_stopped && last != nullptr) found = at(*last, o.over, &o);
      if (found) return found;
    }
    return std::nullopt;
  }

  // The force shown jumps while the axis stands pressed and nothing is ordered.
  Found lost_zero() const {
    const Seen* before = nullptr;
    for (const Seen& s : seen_) {
      if (!s.shown.force_N || !s.arrived) continue;
      if (s.taken < from_) {
        before = &s;
        continue;
      }
      if (before == nullptr || s.taken > from_ + std::chrono::seconds(1)) break;
      const bool stood = s.true_m == before->true_m && is_quiet(s.taken);
      const double jump = std::abs(*s.shown.force_N - *before->shown.force_N);
      const bool pressed = before->true_N > 2 * watch_.order_force_N + digits_N_;
      const double allowed_N = 2 * watch_.order_force_N + 2 * digits_N_ + 0.2 * before->true_N;
      if (!stood || !pressed || jump < allowed_N) break;
      Contradiction c = at(s, *s.arrived + kZeroTime, nullptr);
      return c;
    }
    return std::nullopt;
  }

  // True if no motion of ours is near enough in time to hide a jump, and no force is held.
  bool is_quiet(MonoTime t) const {
    const bool moves = std::ranges::any_of(orders_, [t](const Ordered& o) {
      return o.sent <= t + kZeroTime && (t < o.over + kZeroTime || o.word == "RAMPF");
    });
    return !moves && t + kZeroTime < world_.over_at;
  }

  // From this order on the axis moves by itself to hold a force.
  MonoTime force_held_from(MonoTime t) const {
    for (const Word& w : world_.witness.words) {
      const bool holds = w.is_sent && w.line.find("HOLD mode=force") != std::string::npos;
      if (holds && w.at >= t) return w.at;
    }
    return MonoTime::max();
  }

  // The axis moves between two of our motions although the frame said that it stands.
  Found moved_unasked() const {
    for (std::size_t i = 0; i < orders_.size(); ++i) {
      if (orders_[i].word == "RAMPF") continue;  // a force may be held
      const MonoTime begin = std::max(from_, stands_from(orders_[i]));
      const MonoTime next =
          i + 1 < orders_.size() ? orders_[i + 1].sent : std::max(world_.over_at, begin);
      const MonoTime end = std::min(next, force_held_from(orders_[i].sent));
      std::optional<double> rest;
      for (const Seen& s : seen_) {
        if (s.taken < begin || s.taken > end || !s.shown.travel_m || !s.arrived) continue;
        if (!rest) rest = *s.shown.travel_m;
        const double off = std::abs(*s.shown.travel_m - *rest);
        if (off < watch_.standing_m + 2 * rig_.plant.travel_resolution_m) continue;
        if (*s.arrived > end) break;
        Contradiction c = at(s, *s.arrived, nullptr);
        c.speed_m_s = lie_.what == FrameLie::creep ? std::abs(lie_.value) : fastest_m_s();
        if (c.due > world_.over_at) break;
        return c;
      }
    }
    return std::nullopt;
  }
  double fastest_m_s() const {
    double v = 0;
    for (const Ordered& o : orders_) v = std::max(v, o.speed_m_s);
    return v;
  }
  // When the frame said that it stands. After a motion that was cut short this is STOPPED.
  MonoTime stands_from(const Ordered& o) const {
    for (const Word& w : world_.witness.words) {
      if (w.at < o.over || w.is_sent) continue;
      if (w.line.starts_with("STOPPED") || w.line.starts_with("DONE")) return w.at;
    }
    return MonoTime::max();
  }

  // DONE was said although the last sample before it shows another place.
  Found was_not_there() const {
    for (const Ordered& o : orders_) {
      if (!o.is_done || o.over < from_ || o.sent > to_) continue;
      const Seen* last = nullptr;
      for (const Seen& s : seen_) {
        if (s.arrived && *s.arrived <= o.over && s.taken > o.sent) last = &s;
      }
      if (last == nullptr || !is_off(o, *last) || !stays_off(o)) continue;
      Contradiction c = at(*last, o.over + kAfterDone, &o);
      c.first = o.over;
      return c;
    }
    return std::nullopt;
  }
  // The following samples must show it, too: a motion that ends by itself meanwhile counts as done.
  bool stays_off(const Ordered& o) const {
    for (const Seen& s : seen_) {
      if (s.taken < o.over || !s.arrived) continue;
      if (s.taken > o.over + kAfterDone) break;
      if (!is_off(o, s)) return false;
    }
    return true;
  }
  bool is_off(const Ordered& o, const Seen& s) const {
    const double way_m = o.speed_m_s * 0.1;  // travelled since that sample
    if (o.travel_m) {
      const double off = std::abs(s.shown.travel_m.value_or(*o.travel_m) - *o.travel_m);
      return off > watch_.order_travel_m + way_m + 2 * rig_.plant.travel_resolution_m;
    }
    if (!o.force_N || !s.shown.force_N || o.word == "RAMPF") return false;
    const double off = (*o.force_N - *s.shown.force_N) * o.direction;
    const double settles_N = 0.15 * std::max(std::abs(*o.force_N), s.true_N);
    const double doubt_N = 0.002 * rig_.plant.force_nominal_N + settles_N;
    return off > watch_.order_force_N + 2 * digits_N_ + doubt_N +
                     way_m * rig_.stiffness_N_m(2 * rig_.limit_N);
  }

  Found told_of_fault() const {
    for (const Word& w : world_.witness.words) {
      // An E-stop that was over before the first command cannot be known to the run.
      if (w.is_sent || w.at < from_ || orders_.empty() || w.at < orders_.front().sent) continue;
      const bool estop = w.line.find("kind=\"estop\"") != w.line.npos;
      if (!estop && w.line.find("reason=\"fault\"") == w.line.npos) continue;
      Contradiction c;
      c.taken = from_;
      c.first = w.at;
      c.due = w.at + from_seconds(watch_.reply_s) + kAllowance;
      for (const Seen& s : seen_) {
        if (s.taken <= w.at) c.true_N = s.true_N;
      }
      c.speed_m_s = fastest_m_s();
      return c;
    }
    return std::nullopt;
  }

  const RigWorld& world_;
  const sim::RandomRig& rig_;
  const PrintedWatch& watch_;
  const Falsehood& lie_;
  const std::vector<Seen>& seen_;
  std::vector<Ordered> orders_;
  MonoTime from_, to_;
  double digits_N_ = 0;
};

}  // namespace

std::optional<PrintedWatch> printed_watch(const RigWorld& world, MonoTime at) {
  std::optional<PrintedWatch> out;
  for (const RunEvent& e : world.events) {
    if ((e.kind != EventKind::plan && e.kind != EventKind::watch) || (out && e.t > at)) continue;
    auto j = nlohmann::json::parse(e.detail);
    if (e.kind == EventKind::plan && !j.contains("watch")) continue;
    if (e.kind == EventKind::plan) j = nlohmann::json(j.at("watch"));
    PrintedWatch& w = out.emplace();
    if (!j.at("frozen_force_s").is_null()) w.frozen_force_s = j.at("frozen_force_s");
    w.stall_s = j.at("stall_s");
    w.against_m = j.at("against_mm").get<double>() * 1e-3;
    w.standing_m = j.at("standing_mm").get<double>() * 1e-3;
    w.order_travel_m = j.at("order_travel_mm").get<double>() * 1e-3;
    w.order_force_N = j.at("order_force_N");
    w.reply_s = j.at("reply_s");
  }
  return out;
}

std::optional<Contradiction> contradiction_of(const Trial& t, const PrintedWatch& w,
                                              std::size_t lie) {
  return Look(t, w, lie).find();
}

}  // namespace lcrig::property
