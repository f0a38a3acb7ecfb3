// SPDX-License-Identifier: Apache-2.0
// Compares the steps between samples with the stated steps of travel and force
// (docs/frame-link.md, section 2). A finer step proves that a statement is false. Used by Losses.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/load_frame.hpp"

namespace lcrig {

class StatedSteps {
 public:
  using News = std::pair<EventKind, std::string>;
  explicit StatedSteps(const FrameCapabilities& stated);
  // Each statement is reported once.
  std::vector<News> add(std::span<const FrameSample> batch);

 private:
  // One channel.
  class Steps {
   public:
    Steps(std::optional<double> stated, double rounding) : stated_(stated), rounding_(rounding) {}
    // The finest step, once it proves that the statement is false.
    std::optional<double> add(std::optional<double> value);
    double stated() const { return stated_.value_or(0); }

   private:
    std::optional<double> stated_, last_;
    double rounding_;  // of a step, by the digits of the wire
    double finest_ = 0;
    int finer_ = 0, since_first_ = 0;  // changes: finer ones, and all since the first of these
    bool told_ = false;
  };

  Steps travel_m_, force_N_;
};

}  // namespace lcrig
