// SPDX-License-Identifier: Apache-2.0
#include "budget/search.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::int64_t kSteps[] = {1, 2, 3, 5, 10, 20, 30, 50, 100, 200, 500, 1000, 2000, 5000};

constexpr const char* kOneCycleAlone =
    "one cycle: the interval knows nothing of what differs between cycles, and analyze will print "
    "a wider one, which takes the curve's own shape for scatter";

// Number of repeats that are planned to meet a target, where the protocol itself has only one.
constexpr double kRepeatsForTarget = 3;

// If a result cannot be predicted with this many readings or cycles, more of them will not help.
constexpr std::int64_t kEnoughToPredict = 16;

class Search {
 public:
  explicit Search(const BudgetQuestion& q) : q_(q), knobs_(find_knobs(q.protocol)) {}

  BudgetSetting look(Aperture aperture, double frequency_Hz) const {
    BudgetSetting out;
    out.planned = reckon(aperture, frequency_Hz, {});
    for (const std::int64_t n : kSteps) {
      auto point = with_knob(aperture, frequency_Hz, n);
      if (!point || !point->possible()) continue;
      if (out.planned.tells_repeats() && !point->tells_repeats()) continue;
      out.curve.push_back(std::move(*point));
    }
    if (q_.target) out.to_target = least(aperture, frequency_Hz);
    if (q_.target && out.planned.meets(*q_.target) &&
        (!out.to_target || out.planned.duration_s < out.to_target->duration_s)) {
      out.to_target = out.planned;
    }
    return out;
  }

 private:
  using Changes = std::map<std::string, double>;  // SI

  bool has_knob() const { return !knobs_.readings.empty() || !knobs_.repeats.empty(); }
  const Parameter& knob() const {
    return q_.protocol.parameters.at(knobs_.readings.empty() ? knobs_.repeats : knobs_.readings);
  }

  // Plans `n` readings at each level, at the speed of the meter. Without levels it plans n repeats.
  std::optional<BudgetPoint> with_knob(Aperture aperture, double frequency_Hz, std::int64_t n,
                                       Changes changes = {}) const {
    const auto count = static_cast<double>(n);
    if (!has_knob() || count < knob().min || count > knob().max) return std::nullopt;
    if (knobs_.readings.empty()) return reckon(aperture, frequency_Hz, {{knobs_.repeats, count}});
    LcrSettings lcr = q_.protocol.sample.lcr;
    lcr.aperture = aperture;
    lcr.frequency = Frequency::from_si(frequency_Hz);
    const double each = to_seconds(q_.rig.lcr.conversion_time(lcr));
    const Parameter& within = q_.protocol.parameters.at(knobs_.within);
    const double seconds =
        std::max(std::ceil(count * each * kReadingSlack * 10) / 10, within.min * within.to_si);
    changes[knobs_.readings] = count;
    changes[knobs_.within] = seconds;
    return reckon(aperture, frequency_Hz, changes);
  }

  Changes enough_repeats() const {
    if (knobs_.readings.empty() || knobs_.repeats.empty()) return {};
    const auto& values = q_.environment.values();
    const auto found = values.find(knobs_.repeats);
    const double most = q_.protocol.parameters.at(knobs_.repeats).max;
    if (found == values.end() || found->second >= 2 || most < 2) return {};
    return {{knobs_.repeats, std::min(kRepeatsForTarget, most)}};
  }

  // The least knob that meets the target. The error falls as the knob grows, so it is doubled until
  // the error is small enough, and bisected then: planning a hundred thousand cycles takes long.
  std::optional<BudgetPoint> least(Aperture aperture, double frequency_Hz) const {
    if (!has_knob()) return std::nullopt;
    const auto most = static_cast<std::int64_t>(knob().max);
    auto low = static_cast<std::int64_t>(std::ceil(knob().min)) - 1;
    auto high = low + 1;
    const Changes repeats = enough_repeats();
    auto best = with_knob(aperture, frequency_Hz, high, repeats);
    while (!best || !best->meets(*q_.target)) {
      const bool unknown = best && (!best->possible() || !best->not_predicted.empty());
      if (high >= most || (unknown && high >= kEnoughToPredict)) return std::nullopt;
      low = high;
      high = std::min(2 * high, most);
      best = with_knob(aperture, frequency_Hz, high, repeats);
    }
    while (high - low > 1) {
      const std::int64_t middle = low + (high - low) / 2;
      auto point = with_knob(aperture, frequency_Hz, middle, repeats);
      const bool enough = point && point->meets(*q_.target);
      (enough ? high : low) = middle;
      if (enough) best = std::move(point);
    }
    return best;
  }

  BudgetPoint reckon(Aperture aperture, double frequency_Hz, const Changes& changes) const {
    BudgetPoint out;
    out.aperture = aperture;
    out.frequency_Hz = frequency_Hz;
    Environment environment = q_.environment;
    for (const auto& [name, si] : changes) {
      environment.set(name, si);
      out.parameters[name] = si / q_.protocol.parameters.at(name).to_si;
    }
    Variant variant =
        with_settings(q_.protocol, environment, q_.rig, aperture, Frequency::from_si(frequency_Hz));
    out.note = std::move(variant.note);
    out.follows = variant.by_parameters;
    for (const auto& [name, si] : variant.parameters) {
      out.parameters[name] = si / q_.protocol.parameters.at(name).to_si;
    }
    auto plan = make_plan(variant.protocol, environment, q_.rig);
    if (!plan) {
      out.refused = plan.error().what;
      return out;
    }
    out.duration_s = plan->duration_s;
    out.readings = plan->measure_readings > 0 ? plan->measure_readings : plan->lcr_readings;
    predict(variant.protocol, environment, *plan, out);
    return out;
  }

  void predict(const Protocol& protocol, const Environment& environment, const Plan& plan,
               BudgetPoint& out) const {
    auto run = plan_readings(protocol, environment, q_.rig, plan, q_.curve);
    Result<std::vector<Prediction>> predictions = fail(Errc::bug, "no readings");
    if (run) predictions = predict_errors(*run, q_.options);
    if (!run || !predictions) {
      out.refused = run ? predictions.error().what : run.error().what;
      return;
    }
    out.predictions = std::move(*predictions);
    out.noise_guessed = run->noise_guessed;
    bool any = false;
    for (const Prediction& p : out.predictions) {
      if (!p.reason.empty()) {
        out.not_predicted.push_back(p.quantity);
        continue;
      }
      out.repeats = any ? std::min(out.repeats, p.repeats) : p.repeats;
      any = true;
      out.worst = std::max(out.worst, p.relative());
      out.worst_half_width = std::max(out.worst_half_width, p.relative_half_width());
      out.worst_expanded = std::max(out.worst_expanded, p.uncertainty.expanded / std::abs(p.value));
    }
    if (!any) out.refused = out.predictions.front().reason;
    if (any && !out.tells_repeats()) {
      add_remark(out.note, run->levels.empty() ? kOneCycleAlone : kOneRepeat);
    }
  }

  const BudgetQuestion& q_;
  Knobs knobs_;
};

void mark_front(Budget& budget) {
  std::vector<BudgetPoint*> points;
  for (BudgetSetting& s : budget.settings) {
    if (s.planned.possible()) points.push_back(&s.planned);
    for (BudgetPoint& p : s.curve) points.push_back(&p);
  }
  std::ranges::sort(points, [](const BudgetPoint* a, const BudgetPoint* b) {
    return a->duration_s != b->duration_s ? a->duration_s < b->duration_s
                                          : a->worst_half_width < b->worst_half_width;
  });
  double best = INFINITY;
  for (BudgetPoint* p : points) {
    p->front = p->worst_half_width < best;
    best = std::min(best, p->worst_half_width);
  }
}

}  // namespace

Budget reckon_budget(const BudgetQuestion& question) {
  const Search search(question);
  Budget out;
  out.model_level = question.curve.level;
  out.pressure = rig_for(question.protocol, question.rig).pressure;
  out.target = question.target;
  for (const double frequency : question.frequencies_Hz) {
    for (const Aperture aperture : question.apertures) {
      out.settings.push_back(search.look(aperture, frequency));
    }
  }
  mark_front(out);
  for (const BudgetSetting& s : out.settings) {
    if (!s.to_target) continue;
    const auto order = [](const BudgetPoint& p) {
      return std::pair(p.duration_s, p.worst_half_width);
    };
    if (!out.cheapest || order(*s.to_target) < order(*out.cheapest)) out.cheapest = s.to_target;
  }
  return out;
}

}  // namespace lcrig
