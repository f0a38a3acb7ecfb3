// SPDX-License-Identifier: Apache-2.0
// The places where a run may stop or pause by itself on request: after a step, a level, a cycle, a
// repeat, or a step that the file marks as a safe point. The plan counts these places; the run
// finds the next one.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "protocols/expand.hpp"

namespace lcrig {

// level: one `measure` with the motion before it. cycle: one pass of the innermost loop that loads
// and unloads. repeat: one pass of the outermost loop.
enum class StopPlace { step, level, cycle, repeat, safe_point };
template <>
inline constexpr EnumWords<5> kWordsOf<StopPlace>{"step", "level", "cycle", "repeat", "safe_point"};
std::string place_words(StopPlace place);  // "safe point"
std::string stop_place_words();  // "step, level, cycle, repeat, safe_point"

struct PlaceAhead {
  std::int64_t steps = 1;  // leaf steps to that place, including the current one
  std::string step_id;  // the last of these steps
  double seconds = 0;  // planned time of these steps, without the current one
};

class StopPlaces {
 public:
  // `environment` belongs to the cursors and must outlive this object.
  explicit StopPlaces(const Environment& environment) : environment_(environment) {}

  // Whether the step that `cursor` returned last ends such a place.
  bool ends(StopPlace place, const StepCursor& cursor, const Step& step);
  // The end of the level, cycle or repeat that contains the step that `cursor` returned last; if
  // none does, the end of that step. For a safe point, the next one. `level_begun`: a motion has
  // been made since the last `measure`. nullopt: no safe point follows.
  std::optional<PlaceAhead> ahead(StopPlace place, const StepCursor& cursor, const Step& step,
                                  bool level_begun,
                                  const std::function<double(const std::string&)>& planned_s);

 private:
  const Step* loop_of(StopPlace place, const StepCursor& cursor);
  bool loads_and_unloads(const StepCursor::Pass& pass);

  const Environment& environment_;
  std::map<const Step*, bool> known_;  // whether each visited loop loads and unloads
};

bool begins_level(const Step& step);

}  // namespace lcrig
