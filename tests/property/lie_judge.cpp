// SPDX-License-Identifier: Apache-2.0
#include "tests/property/lie_judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/property/contradiction.hpp"
#include "tests/property/own_bounds.hpp"

namespace lcrig::property {

namespace {

constexpr auto kTogether = std::chrono::milliseconds(2);  // two lines sent together
constexpr auto kStopping = std::chrono::seconds(1);
constexpr double kStands_m = 1e-9;  // an axis that stands does not move at all; this is rounding

bool has_one(const std::string& text, const std::vector<std::string_view>& words) {
  return std::ranges::any_of(words, [&](auto w) { return text.find(w) != text.npos; });
}

class LieJudge {
 public:
  LieJudge(Trial& t, Counters& counters, LieTable& table)
      : t_(t), w_(t.world()), counters_(counters), table_(table), lies_(t.what().lies) {}

  Broken judge() {
    if (w_.refused) {
      ++counters_["refused with a lie"];
      return {};
    }
    judge_end();
    MonoTime from = MonoTime::max();
    for (const Trial::Told& told : t_.told()) from = std::min(from, told.from.value_or(from));
    watch_ = printed_watch(w_, from);
    count_told();
    if (!watch_) {
      ++counters_["no watch printed"];
      return out_;
    }
    find_first();
    judge_stop_lies();
    if (first_) judge_first();
    return out_;
  }

 private:
  const std::string& reason() const { return w_.result->reason; }
  bool succeeded() const { return w_.result && w_.result->exit_status == ExitStatus::success; }
  bool tells(FrameLie lie) const {
    return std::ranges::any_of(lies_, [lie](const Falsehood& f) { return f.what == lie; });
  }
  bool tells_after_last_stop(FrameLie lie) const {
    const auto stops = stops_sent(w_.witness);
    for (std::size_t i = 0; i < lies_.size(); ++i) {
      const auto from = t_.told()[i].from;
      if (lies_[i].what == lie && from && !stops.empty() && *from >= stops.back()) return true;
    }
    return false;
  }
  std::string name() const { return std::string(to_string(lies_[lie_].what)); }
  template <class... A>
  void broken(fmt::format_string<A...> words, A&&... a) {
    out_.push_back(fmt::format(words, std::forward<A>(a)...));
  }

  // Whatever the lie, the run ends by itself. At the end the frame stands, or the reason says that
  // it may not.
  void judge_end() {
    if (!w_.is_clean) broken("clean: something still waits after the run");
    if (!w_.replay_differs.empty()) broken("replay: {}", w_.replay_differs);
    if (w_.too_long) broken("long: it did not end by itself");
    if (w_.stood || !w_.result) return;
    const bool told = !succeeded() && has_one(reason(), {"standstill", "E-stop", "STOP"});
    // The run cannot know of a motion just before its end, or after it.
    const bool late = tells(FrameLie::order_late) || tells_after_last_stop(FrameLie::creep);
    if (!told && !late) broken("standing: the frame moves at the end, `{}`", reason());
  }

  void count_told() {
    for (std::size_t i = 0; i < lies_.size(); ++i) {
      if (!t_.told()[i].from) continue;
      const std::string lie(to_string(lies_[i].what));
      ++counters_[lie + ": told"];
      LieFigures& f = table_.of(lies_[i].what);
      ++f.told;
      const double part = peak_N(*t_.told()[i].from, MonoTime::max()) / t_.limit_N();
      if (part > f.worst_of_limit) f.worst_of_limit = part, f.worst_seed = t_.what().rig;
    }
  }
  double peak_N(MonoTime from, MonoTime to) const {
    double most = 0;
    for (const auto& s : w_.witness.seen) {
      if (s.taken >= from && s.taken <= to) most = std::max(most, s.true_N);
    }
    return most;
  }

  void find_first() {
    for (std::size_t i = 0; i < lies_.size(); ++i) {
      const auto c = contradiction_of(t_, *watch_, i);
      if (!c) continue;
      const std::string lie(to_string(lies_[i].what));
      ++counters_[lie + ": contradicted"];
      ++table_.of(lies_[i].what).contradicted;
      if (first_ && first_->due <= c->due) continue;
      first_ = c;
      lie_ = i;
    }
  }

  // After a STOP that the frame ignored or did not confirm, the run must fail, name the lie and
  // order no more motions.
  void judge_stop_lies() {
    using enum FrameLie;
    for (std::size_t i = 0; i < lies_.size(); ++i) {
      const FrameLie what = lies_[i].what;
      if (what != stop_unconfirmed && what != stop_ignored) continue;
      const auto& told = t_.told()[i];
      if (!told.from || lies_[i].lasts_s > 0) continue;
      const auto stops = stops_sent(w_.witness);
      const auto stop = std::ranges::find_if(stops, [&](MonoTime s) { return s > *told.from; });
      if (stop == stops.end() || was_lost_before(MonoTime::max())) continue;
      const std::string lie(to_string(what));
      ++counters_[lie + ": contradicted"];
      ++table_.of(what).contradicted;
      if (succeeded()) {
        broken("success: {}: STOP was not confirmed, and the run succeeded", lie);
        continue;
      }
      if (!has_one(reason(), words_of(what))) broken("words: {}: `{}`", lie, reason());
      // A motion that was sent together with the first STOP does not count.
      for (const Ordered& o : ordered_motions(w_.witness)) {
        if (o.sent > *stop + kTogether) return broken("again: {}: {} after the STOP", lie, o.word);
      }
      ++table_.of(what).noticed;
    }
  }

  bool was_lost_before(MonoTime t) const {
    return std::ranges::any_of(
        w_.events, [t](const RunEvent& e) { return e.kind == EventKind::loss && e.t <= t; });
  }

  std::optional<MonoTime> first_stop() const {
    const MonoTime from = *t_.told()[lie_].from;
    for (const MonoTime s : stops_sent(w_.witness)) {
      if (s >= std::min(first_->taken, first_->first) && s >= from) return s;
    }
    return std::nullopt;
  }

  // The run stopped and named the lie before our arithmetic saw it. What follows is the way back.
  bool was_named_before() const {
    const MonoTime from = *t_.told()[lie_].from;
    const auto stops = stops_sent(w_.witness);
    const bool stopped =
        std::ranges::any_of(stops, [&](MonoTime s) { return s >= from && s < first_->taken; });
    if (!stopped || succeeded() || !w_.result) return false;
    const Distrust distrust = distrust_of(lies_[lie_].what);
    return (distrust == Distrust::force || distrust == Distrust::gateway) &&
           has_one(reason(), words_of(lies_[lie_].what));
  }

  // A STOP was sent and not yet answered, so there is nothing to add to it.
  bool was_being_stopped() const {
    bool owed = false;
    for (const auto& w : w_.witness.words) {
      if (w.at > first_->due) break;
      if (w.is_sent && w.line == "STOP") {
        owed = true;
      } else if (!w.is_sent && w.line.starts_with("STOPPED") && w.at < first_->taken) {
        owed = false;
      }
    }
    return owed && !first_stop_is_first();
  }
  // The frame confirmed a STOP, nothing was ordered since, and it truly stands.
  bool stands_stopped() const {
    bool stopped = false;
    MonoTime since{};
    for (const auto& w : w_.witness.words) {
      if (w.at >= first_->first) break;
      if (w.is_sent && w.line == "STOP") stopped = false;
      if (w.is_sent || !w.line.starts_with("STOPPED")) continue;
      stopped = true;
      since = w.at;
    }
    if (!stopped) return false;
    if (std::ranges::any_of(ordered_motions(w_.witness), [&](const Ordered& o) {
          return o.sent > since && o.sent <= first_->due;
        })) {
      return false;
    }
    double low_m = HUGE_VAL, high_m = -HUGE_VAL;
    for (const auto& s : w_.witness.seen) {
      if (s.taken < since || s.taken > first_->due) continue;
      low_m = std::min(low_m, s.true_m);
      high_m = std::max(high_m, s.true_m);
    }
    return high_m - low_m < kStands_m;
  }
  // The run was stopped for another reason and has ordered nothing since. Or, with two lies, it is
  // on its way back because it no longer trusts the force.
  bool was_at_its_end() const {
    const auto stops = stops_sent(w_.witness);
    const bool of_force = distrust_of(lies_[lie_].what) == Distrust::force;
    MonoTime from = *t_.told()[lie_].from;
    for (const Trial::Told& told : t_.told()) from = std::min(from, told.from.value_or(from));
    const bool stopped =
        std::ranges::any_of(stops, [&](MonoTime s) { return s > from && s < first_->taken; });
    if (lies_.size() > 1 && of_force && stopped && !succeeded()) return true;
    if (succeeded() || stops.size() < 2 || stops.back() >= first_->taken) return false;
    return std::ranges::none_of(ordered_motions(w_.witness),
                                [&](const Ordered& o) { return o.sent > stops.back(); });
  }
  // The first STOP of the run is the reaction to this lie.
  bool first_stop_is_first() const {
    const auto stop = first_stop();
    return stop && *stop <= first_->due;
  }

  void judge_first() {
    if (was_lost_before(first_->due)) return;
    if (was_being_stopped() || stands_stopped() || was_at_its_end()) {
      ++counters_["shown while it was being stopped"];
      return;
    }
    LieFigures& f = table_.of(lies_[lie_].what);
    if (was_named_before()) {
      ++f.noticed;
      ++counters_[name() + ": noticed"];
      return f.to_stop_s.push_back(0);
    }
    const auto stop = first_stop();
    if (first_->due > w_.over_at && !stop) return;
    if (!stop || *stop > first_->due) {
      return broken(
          "late: {}: it showed at {:.3f} s, STOP was due at {:.3f} s and came {}", name(),
          to_seconds(first_->first.time_since_epoch()), to_seconds(first_->due.time_since_epoch()),
          stop ? fmt::format("at {:.3f} s", to_seconds(stop->time_since_epoch())) : "never");
    }
    f.to_stop_s.push_back(std::max(0.0, to_seconds(*stop - first_->first)));
    const std::size_t before = out_.size();
    judge_result();
    judge_motions(*stop);
    judge_force(*stop, f);
    if (out_.size() == before) {
      ++f.noticed;
      ++counters_[name() + ": noticed"];
    }
  }

  // A creep that really presses beyond the limit is stopped because of the limit.
  bool crept_beyond_limit() const {
    return tells(FrameLie::creep) && has_one(reason(), {"outside the limits"}) &&
           peak_N(*t_.told()[lie_].from, MonoTime::max()) > t_.limit_N();
  }

  void judge_result() {
    if (!w_.result) return;
    if (succeeded()) return broken("success: {}: it showed, and the run succeeded", name());
    if (!t_.what().happenings.empty()) return;
    const bool named = std::ranges::any_of(
        lies_, [this](const Falsehood& l) { return has_one(reason(), words_of(l.what)); });
    if (!named && !crept_beyond_limit()) {
      broken("words: {}: the reason does not name it: `{}`", name(), reason());
    }
  }

  void judge_motions(MonoTime stop) {
    const Distrust distrust = distrust_of(lies_[lie_].what);
    // With two lies, the other one may have been noticed first, and after that one the frame may go
    // back.
    if (lies_.size() > 1 && !has_one(reason(), {"does not move", "against the command"})) return;
    for (const Ordered& o : ordered_motions(w_.witness)) {
      if (o.sent <= stop + kTogether) continue;
      const bool may = distrust == Distrust::gateway || distrust == Distrust::nobody ||
                       (distrust == Distrust::force && o.direction < 0);
      if (!may) {
        return broken("again: {}: {:.3f} s after the STOP came {}", name(),
                      to_seconds(o.sent - stop), o.word);
      }
    }
  }

  // The bound counts from the first false sample. It allows for the time that the plan prints, the
  // speed at that moment and the stopping distance, on the stiffest contact that was told.
  void judge_force(MonoTime stop, LieFigures& f) {
    if (tells(FrameLie::stop_ignored) || tells(FrameLie::order_late)) return;
    const OwnContact contact(t_.rig());
    if (!contact.is_bounded() || t_.is_conditional()) return;
    const double time_s = to_seconds(first_->due - first_->taken);
    const double limit_N = t_.limit_N() + own_uncertainty_N(t_.rig(), t_.limit_N());
    const double begun_N = std::max(first_->true_N, 0.0) + first_->rate_N_s * time_s;
    const double v = std::max(first_->speed_m_s, approach_m_s());
    const double way_m = v * time_s + own_stopping_way_m(t_.rig(), v);
    const double bound = std::max(limit_N, contact.force_after_N(begun_N, way_m));
    const double peak = peak_N(first_->taken, stop + kStopping);
    f.worst_of_bound = std::max(f.worst_of_bound, peak / bound);
    if (peak <= bound) return;
    broken("force: {}: {:.5g} N were pressed, and {:.3f} s at {:.4g} um/s allow {:.5g} N", name(),
           peak, time_s, v * 1e6, bound);
  }
  // A force loop that approaches contact does so at its own speed.
  double approach_m_s() const {
    if (first_->rate_N_s <= 0) return 0;
    const double k = t_.rig().stiffness_N_m(0);
    return std::max(t_.rig().frame.approach_m_s, first_->rate_N_s / k);
  }

  Trial& t_;
  RigWorld& w_;
  Counters& counters_;
  LieTable& table_;
  const std::vector<Falsehood>& lies_;
  std::optional<PrintedWatch> watch_;
  std::optional<Contradiction> first_;
  std::size_t lie_ = 0;
  Broken out_;
};

}  // namespace

Broken lies_come_out(Trial& t, Counters& counters) {
  t.lie_figures = LieTable();
  return LieJudge(t, counters, t.lie_figures).judge();
}

}  // namespace lcrig::property
