// SPDX-License-Identifier: Apache-2.0
#include "protocols/stop_places.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>
#include <set>
#include <vector>

namespace lcrig {

namespace {

// Collects the loads that one pass of a loop goes to. With two different loads the loop loads and
// unloads, even if only by starting over.
class Loads {
 public:
  // `fixed`: variables of outer sweeps that have not begun. Each has one unknown value.
  explicit Loads(const Environment& environment, std::vector<std::string> fixed = {})
      : environment_(environment), fixed_(std::move(fixed)) {}

  void add(const Steps& steps) {
    for (const Step& step : steps) {
      const StepFacts facts = facts_of(step);
      const std::string* variable = facts.loop ? facts.loop->variable() : nullptr;
      if (variable != nullptr) swept_.push_back(*variable);
      if (facts.loop) add(facts.loop->steps);
      if (variable != nullptr) swept_.pop_back();
      if (facts.aim != nullptr) add(*facts.aim);
    }
  }
  bool are_several() const { return seen_.size() > 1; }

 private:
  void add(const Target& aim) {
    const Number& n = aim.value;
    if (std::ranges::find(swept_, n.name) != swept_.end()) {  // takes several values
      seen_.insert(fmt::format("{} {} first", static_cast<int>(aim.kind), n.name));
      seen_.insert(fmt::format("{} {} last", static_cast<int>(aim.kind), n.name));
      return;
    }
    if (std::ranges::find(fixed_, n.name) != fixed_.end()) {
      seen_.insert(fmt::format("{} {}", static_cast<int>(aim.kind), n.name));
      return;
    }
    const double value = environment_.get(n);
    const bool free = aim.kind == TargetKind::gap ? value >= 0 : is_force(aim) && value <= 0;
    seen_.insert(free ? std::string("free")
                      : fmt::format("{} {}", static_cast<int>(aim.kind), value));
  }

  const Environment& environment_;
  std::vector<std::string> fixed_, swept_;  // `swept_`: variables of inner sweeps
  std::set<std::string> seen_;
};

// Whether the loop contains another one that loads and unloads. Then its pass is more than one
// cycle.
bool loads_inside(const Steps& steps, const Environment& environment,
                  const std::vector<std::string>& fixed) {
  for (const Step& step : steps) {
    const Loop* loop = facts_of(step).loop;
    if (!loop) continue;
    std::vector<std::string> names = fixed;
    if (const std::string* variable = loop->variable()) names.push_back(*variable);
    Loads loads(environment, names);
    loads.add(loop->steps);
    if (loads.are_several() || loads_inside(loop->steps, environment, names)) return true;
  }
  return false;
}

// Whether the last step that the cursor returned ends a pass of `loop`.
bool ends_pass(const StepCursor& cursor, const Step* loop) {
  for (const StepCursor::Pass& around : cursor.loops() | std::views::reverse) {
    if (around.at != around.loop->steps.size()) return false;
    if (around.step == loop) return true;
    if (around.index != around.count) return false;
  }
  return false;
}

bool is_measure(const Step& step) {
  return facts_of(step).measures != nullptr;
}

// Whether, from this step on, a `measure` comes before the next motion.
bool measures_next(StepCursor& cursor, const Step* step) {
  for (bool first = true; step != nullptr; step = cursor.next(), first = false) {
    if (is_measure(*step)) return true;
    if (!first && begins_level(*step)) return false;
  }
  return false;
}

}  // namespace

std::string place_words(StopPlace place) {
  return place == StopPlace::safe_point ? "safe point" : std::string(to_string(place));
}

std::string stop_place_words() {
  return fmt::format("{}", fmt::join(kWordsOf<StopPlace>, ", "));
}

bool begins_level(const Step& step) {
  const StepFacts facts = facts_of(step);
  return facts.moves || facts.places_weight;
}

bool StopPlaces::loads_and_unloads(const StepCursor::Pass& pass) {
  const auto [it, is_new] = known_.try_emplace(pass.step, false);
  if (is_new) {
    Loads loads(environment_);
    loads.add(pass.loop->steps);
    it->second = loads.are_several();
  }
  return it->second;
}

// The loop whose pass ends at the place; nullptr: the step is in no such loop.
const Step* StopPlaces::loop_of(StopPlace place, const StepCursor& cursor) {
  const auto& loops = cursor.loops();
  if (place == StopPlace::repeat) return loops.empty() ? nullptr : loops.front().step;
  for (const StepCursor::Pass& pass : loops | std::views::reverse) {
    if (!loads_and_unloads(pass)) continue;
    return loads_inside(pass.loop->steps, cursor.environment(), {}) ? nullptr : pass.step;
  }
  return nullptr;
}

bool StopPlaces::ends(StopPlace place, const StepCursor& cursor, const Step& step) {
  switch (place) {
    case StopPlace::step: return true;
    case StopPlace::level: return is_measure(step);
    case StopPlace::safe_point: return step.safe_point;
    case StopPlace::cycle:
    case StopPlace::repeat: break;
  }
  return ends_pass(cursor, loop_of(place, cursor));
}

std::optional<PlaceAhead> StopPlaces::ahead(
    StopPlace place, const StepCursor& cursor, const Step& step, bool level_begun,
    const std::function<double(const std::string&)>& planned_s) {
  Environment values = cursor.environment();
  StepCursor walk(cursor, values);
  const Step* loop = nullptr;
  bool under_way = place == StopPlace::safe_point;
  if (place == StopPlace::level) {
    Environment more = values;
    StepCursor look(cursor, more);
    under_way = (level_begun || is_measure(step)) && measures_next(look, &step);
  } else if (place == StopPlace::cycle || place == StopPlace::repeat) {
    loop = loop_of(place, cursor);
    under_way = loop != nullptr;
  }
  const auto is_there = [&](const Step& at) {
    return loop != nullptr ? ends_pass(walk, loop) : ends(place, walk, at);
  };
  PlaceAhead out;
  const Step* at = &step;
  while (under_way && !is_there(*at)) {
    at = walk.next();
    if (at == nullptr) return std::nullopt;
    ++out.steps;
    out.seconds += planned_s(at->id);
  }
  out.step_id = at->id;
  return out;
}

}  // namespace lcrig
