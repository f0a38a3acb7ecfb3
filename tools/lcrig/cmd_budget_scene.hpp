// SPDX-License-Identifier: Apache-2.0
// Makes the input of a prediction: the rig of a bench and the curve of a specimen. `lcrig budget`
// and `lcrig rehearse` use it, and with `lcrig protocol plan` the failure of a bench.
#pragma once

#include <string>

#include "budget/planned_run.hpp"
#include "daemon/rehearse.hpp"
#include "protocols/plan/check.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/library_path.hpp"

namespace lcrig::cli {

// The failure for a bench that was refused, as it was asked for, with the specimen if there was
// one.
Failure bench_refused(const Context& context, const Error& error, BenchRequest bench);

// Failure: there is no such bench, or its file is wrong.
Outcome<Rig> budget_rig(const Context& context, const std::string& bench,
                        const LibraryFile& specimen, const Protocol& protocol);
// Errors: wrong file of the specimen; limits that the frame cannot have; no model can compute it.
Result<SpecimenCurve> budget_curve(const LibraryFile& specimen, const Protocol& protocol,
                                   const Environment& environment, const Rig& rig);

}  // namespace lcrig::cli
