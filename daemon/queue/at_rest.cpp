// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/at_rest.hpp"

#include "storage/run_summary.hpp"

namespace lcrig {

namespace {

// Leads that lie otherwise than in the last run change the strays by about this much; a file knows
// neither strays nor fringe, and its permittivity is a data sheet's.
constexpr double kOwnPart = 0.03, kOwnStray_F = 0.1e-12;
constexpr double kFilePart = 0.30, kFileStray_F = 1e-12;

ExpectedAtRest expected(double c0_F, double part, double stray_F, std::string source) {
  ExpectedAtRest out;
  out.capacitance_F = c0_F;
  out.tolerance_F = part * c0_F + stray_F;
  out.source = std::move(source);
  return out;
}

}  // namespace

Result<std::optional<ExpectedAtRest>> expected_at_rest(const Database& db, const PreparedRun& run) {
  const double frequency_Hz = run.protocol.sample.lcr.frequency.si();
  auto last = last_c0(db, run.request.specimen_name, frequency_Hz);
  if (!last) return fail(last.error());
  if (*last) {
    return std::optional(
        expected((*last)->c0_F, kOwnPart, kOwnStray_F, fmt::format("in run {}", (*last)->run)));
  }
  if (!run.specimen || run.specimen->c0_F() <= 0) return std::optional<ExpectedAtRest>();
  return std::optional(expected(run.specimen->c0_F(), kFilePart, kFileStray_F, "by its file"));
}

}  // namespace lcrig
