// SPDX-License-Identifier: Apache-2.0
// A step of a protocol. Code that reads steps uses their facts and the functions of `Action`, and
// includes no kind of step: only file/step_kinds.hpp, for the parser, names all kinds.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "protocols/steps/facts.hpp"

namespace lcrig {

// Classes that the functions of a step use.
struct StepReader;  // file/step_reader.hpp
class PlannedRig;  // plan/planned_rig.hpp
struct StepPlan;
struct RunParts;  // run/run_parts.hpp
struct StepProgress;  // steps/progress.hpp

// What a step does. Each kind derives from `StepOf` and adds its data and
//   kWord     the word after "do" in a file,
//   parse()   reads its keys,
//   Progress  what it remembers while it runs (progress.hpp),
// and the functions that have no default here, so that a kind that lacks one does not compile.
class Action {
 public:
  virtual ~Action() = default;

  virtual std::string_view word() const = 0;
  virtual StepFacts facts() const = 0;
  virtual std::shared_ptr<Action> copy() const = 0;
  virtual std::unique_ptr<StepProgress> new_progress() const = 0;
  // Its duration, its worst effect on the specimen, and whether that is allowed.
  virtual StepPlan plan(PlannedRig& rig) const = 0;
  // Its actions in a run. It ends by itself or with an error. An interrupt cancels it; to continue,
  // it is called again with the same progress, which `new_progress` made.
  virtual Task<Result<>> execute(RunParts& run, StepProgress& remembered) const = 0;
};

template <class Kind, class Base = Action>
struct StepOf : Base {
  std::string_view word() const final { return Kind::kWord; }
  std::shared_ptr<Action> copy() const final {
    return std::make_shared<Kind>(static_cast<const Kind&>(*this));
  }
  std::unique_ptr<StepProgress> new_progress() const final {
    return std::make_unique<typename Kind::Progress>();
  }

 private:
  friend Kind;
  StepOf() = default;
};

struct Step {
  std::string id;  // unique in the file
  std::string pointer;  // JSON pointer, for messages
  bool safe_point = false;  // the run may be stopped after it (stop_places.hpp)
  std::shared_ptr<const Action> action;  // shared by copies of the protocol
};
using Steps = std::vector<Step>;

// A step with inner steps. Plan and run visit these one by one (expand.hpp), and never the loop
// itself.
class Loop : public Action {
 public:
  Steps steps;

  virtual std::int64_t passes(const Environment& environment) const = 0;
  virtual const Number* repeats() const = 0;  // nullptr: it does more than repeat
  virtual const std::string* variable() const = 0;  // that it sets; nullptr: none
  // The values of the variable lie between these.
  virtual std::vector<const Number*> ends() const = 0;
  // `pass` counts from 1.
  virtual void set_variable(std::int64_t pass, Environment& environment) const = 0;

  StepFacts facts() const final;
  StepPlan plan(PlannedRig& rig) const final;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const final;
};

// The word after "do": "find_contact".
inline std::string_view kind_of(const Step& step) {
  return step.action->word();
}
inline StepFacts facts_of(const Step& step) {
  return step.action->facts();
}

}  // namespace lcrig
