// SPDX-License-Identifier: Apache-2.0
#include "analysis/report/model_curve.hpp"
#include "analysis/report/report.hpp"

namespace lcrig {

namespace {

void add_model(ReportRun& out) {
  const RunRow& row = out.data.row;
  if (row.specimen_text.empty()) {
    out.no_model = "no specimen file is stored with the run";
    return;
  }
  if (!out.data.area_m2) {
    out.no_model = "the probe's diameter is not known, so there are no pressures";
    return;
  }
  if (const auto whole = require_whole_disc(out.data.pressure); !whole) {
    out.no_model = whole.error().what;
    return;
  }
  report::ModelRequest request;
  request.specimen_text = row.specimen_text;
  request.specimen_name = row.specimen_name;
  request.level = row.model_level;
  request.choice_json = row.model_error_json;
  request.area_m2 = *out.data.area_m2;
  for (const CurvePoint& p : out.analysis.curve) request.pressure_kPa.push_back(p.pressure_kPa);
  for (const CycleResult& c : out.analysis.cycles) {
    request.pressure_kPa.push_back(c.peak_kPa.value_or(0));
  }
  auto answer = report::evaluate_model(request);
  if (!answer) {
    out.no_model = answer.error().what;
    return;
  }
  ModelledCurve model;
  model.level = std::move(answer->level);
  model.note = std::move(answer->note);
  model.error_estimate = answer->error_estimate;
  const auto points = static_cast<std::ptrdiff_t>(out.analysis.curve.size());
  const auto& all = answer->delta_C_fF;
  model.delta_C_fF.assign(all.begin(), all.begin() + points);
  model.peak_delta_C_fF.assign(all.begin() + points, all.end());
  model.pressure_kPa = std::move(answer->smooth_kPa);
  model.smooth_delta_C_fF = std::move(answer->smooth_fF);
  out.model = std::move(model);
}

}  // namespace

Result<ReportRun> load_report_run(const Database& db, std::int64_t run,
                                  const AnalysisOptions& options) {
  ReportRun out;
  if (auto r = keep(load_run_data(db, run), out.data); !r) return fail(r.error());
  if (auto r = keep(analyse(out.data, options), out.analysis); !r) return fail(r.error());
  if (auto r = keep(verify_chain(db, run), out.chain); !r) return fail(r.error());
  if (auto r = keep(get_run_notes(db, run), out.notes); !r) return fail(r.error());
  add_model(out);
  return out;
}

}  // namespace lcrig
