// SPDX-License-Identifier: Apache-2.0
#include "analysis/measured_noise.hpp"

#include <cmath>

#include "analysis/definitions.hpp"
#include "analysis/metrics.hpp"

namespace lcrig {

Result<MeasuredNoise> measured_noise(const Database& db, std::int64_t run) {
  const auto data = load_run_data(db, run);
  if (!data) return fail(data.error());
  const auto analysis = analyse(*data);
  if (!analysis) return fail(analysis.error());
  if (!analysis->noise) {
    return fail(Errc::invalid_request, "run {} does not tell the noise of a reading: {}", run,
                analysis->noise.reason);
  }
  const AnalysisOptions options;
  const RunView view = look_at(*data, options);
  if (!view.setting_known) {
    return fail(Errc::invalid_request, "run {} does not tell the settings of the meter", run);
  }
  MeasuredNoise out;
  out.meter = view.setting;
  out.reading_F = analysis->noise.value() * 1e-15;
  // The view's noise is that of forces interpolated between samples, which is smaller.
  if (view.force_noise_N > 0) out.force_N = view.force_noise_N / std::sqrt(kInterpolated);
  return out;
}

}  // namespace lcrig
