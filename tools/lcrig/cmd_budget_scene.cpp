// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/cmd_budget_scene.hpp"

#include "daemon/rehearse.hpp"
#include "model/specimen_file.hpp"
#include "protocols/expand.hpp"
#include "protocols/plan/limits.hpp"
#include "tools/lcrig/protocol_request.hpp"

namespace lcrig::cli {

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
  if (!rig) return bench_refused(rig.error(), file->has_value());
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
