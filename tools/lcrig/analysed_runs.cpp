// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/analysed_runs.hpp"

#include "storage/chain.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

std::vector<Comparison> AnalysedRuns::compared() const {
  std::vector<const RunData*> loaded;
  loaded.reserve(data.size());
  for (const RunData& d : data) loaded.push_back(&d);
  return compare(analyses, analyses_of(std::move(loaded)));
}

Outcome<AnalysedRuns> analyse_runs(const Context& context, const std::vector<std::string>& runs,
                                   const AnalysisOptions& options) {
  auto db = open_runs(context);
  if (!db) return db.error();
  AnalysedRuns out;
  for (const auto& text : runs) {
    auto run = named_run(context, *db, text);
    if (!run) return run.error();
    auto checked = verify_aside(*db, *run);
    const auto refuse = [&](const Error& error) {
      const auto look = next_command(context.global, {"runs", "show", text});
      return Failure(error, next_after(error, look));
    };
    auto data = load_run_data(*db, *run);
    if (!data) return refuse(data.error());
    auto analysis = analyse(*data, options);
    if (!analysis) return refuse(analysis.error());
    const auto chain = checked.get();
    if (!chain) return Failure(chain.error(), next_after(chain.error()));
    if (!chain->intact) analysis->notes.insert(analysis->notes.begin(), remark_on(*chain));
    out.data.push_back(std::move(*data));
    out.analyses.push_back(std::move(*analysis));
  }
  return out;
}

}  // namespace lcrig::cli
