// SPDX-License-Identifier: Apache-2.0
// The options of every command that analyses runs: declared once, so that a report can be asked for
// whatever `analyze` can.
#pragma once

#include <string>
#include <vector>

#include "analysis/analysis.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

class AnalysisArguments {
 public:
  void declare(ArgumentList& list);
  // Errors: a value that makes no sense. `command`: "analyze", whose help is proposed.
  Outcome<AnalysisOptions> read(const std::string& command) const;

 private:
  std::vector<std::string> ranges_;
  AnalysisOptions wanted_;
};

}  // namespace lcrig::cli
