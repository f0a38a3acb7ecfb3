// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/cmd_budget_scene.hpp"

#include <fmt/format.h>

#include "base/doc_page.hpp"
#include "daemon/rehearse.hpp"
#include "model/specimen_file.hpp"
#include "protocols/expand.hpp"
#include "protocols/rig/limits.hpp"
#include "storage/runs.hpp"
#include "tools/lcrig/protocol_request.hpp"

namespace lcrig::cli {

Failure bench_refused(const Context& context, const Error& error, BenchRequest bench) {
  const bool of_a_file = !bench.bench_text.empty() || replay_directory(bench.bench);
  if (const auto specimen = parse_specimen(bench.specimen_text, bench.specimen_name)) {
    bench.specimen_text = bench.specimen_name = "";
    auto rig = context.daemon.bench_rig(bench);
    if (rig) put_disc(*specimen, rig->pressure);
    if (rig && !require_whole_disc(rig->pressure)) {
      return Failure(error,
                     fmt::format("change one of the two: {} describes the probe, {} the disc "
                                 "and its plate",
                                 doc_page("bench-file"), doc_page("specimen-file")));
    }
  }
  const std::string page = doc_page("bench-file");
  return Failure(error, of_a_file ? "correct the file; " + page + " describes it"
                                  : page + " tells how to write one");
}

Outcome<Rig> budget_rig(const Context& context, const std::string& bench,
                        const LibraryFile& specimen, const Protocol& protocol) {
  BenchRequest request;
  request.bench = bench;
  auto file = LibraryPath(context.env).find(LibraryKind::bench, bench);
  if (!file) return file.error();
  if (*file) request.bench_text = std::move((*file)->text);
  request.specimen_name = specimen.name;
  request.specimen_text = specimen.text;
  request.weights = places_weights(protocol.steps);
  auto rig = context.daemon.bench_rig(request);
  if (!rig) return bench_refused(context, rig.error(), request);
  return std::move(*rig);
}

Result<SpecimenCurve> budget_curve(const LibraryFile& file, const Protocol& protocol,
                                   const Environment& environment, const Rig& rig) {
  constexpr double kForceReserve = 1.2;  // the table ends beyond the plan's largest force
  auto specimen = parse_specimen(file.text, file.name);
  if (!specimen) return fail(specimen.error());
  const auto limits = bind_limits(protocol, environment, rig.frame);
  if (!limits) return fail(limits.error());
  const Force most = Force::from_si(kForceReserve * limits->force_max_N);
  return tabulate(*specimen, most, rig_for(protocol, rig).pressure);
}

}  // namespace lcrig::cli
