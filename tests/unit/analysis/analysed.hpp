// SPDX-License-Identifier: Apache-2.0
// Synthetic runs, and their analysis. For the unit tests of the analysis.
#pragma once

#include <gtest/gtest.h>

#include "analysis/analysis.hpp"
#include "tests/support/synthetic_run.hpp"

namespace lcrig {

inline RunAnalysis analysed(SyntheticRun& run, const AnalysisOptions& options = {}) {
  auto out = analyse(run.db(), run.run(), options);
  EXPECT_TRUE(out) << (out ? "" : out.error().what);
  return out ? std::move(*out) : RunAnalysis();
}

inline RunAnalysis of_static(const SyntheticRun::Static& s, const AnalysisOptions& options = {}) {
  SyntheticRun run;
  run.begin();
  run.play(s);
  run.end();
  return analysed(run, options);
}

// Readings as fast as those of the meter.
inline RunAnalysis of_dynamic(const SyntheticRun::Dynamic& d) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  run.play(d);
  run.end();
  return analysed(run);
}

inline bool holds(const Metric& m, double truth) {
  const auto& i = *m.estimate->interval;
  return i[0] <= truth && truth <= i[1];
}

}  // namespace lcrig
