// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/terms.hpp"

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "daemon/control/fields.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

void between_field(FieldWriter& f, const std::optional<DayWindow>& between) {
  f.text_or_null("between", between ? to_string(*between) : "");
}

void between_field(ParamsReader& in, std::optional<DayWindow>& between) {
  std::string text;
  in.text_or_null("between", text);
  if (text.empty()) return;
  between = parse_day_window(text);
  if (!between) in.refuse("between", "expected two times of the day, such as 18:00-06:00");
}

}  // namespace

template <class F>
void fields(F& f, Of<F, QueueTerms>& t) {
  f.word("on_failure", t.on_failure);
  f.integer("failures_max", t.failures_max);
  f.boolean("unattended", t.unattended);
  f.number("rest_s", t.rest_s);
  f.integer("not_before_unix_s", t.not_before_unix_s);
  f.integer("not_after_unix_s", t.not_after_unix_s);
  between_field(f, t.between);
  f.text("probe", t.probe, false, kNameMax);
  f.text("fixture", t.fixture, false, kNameMax);
}

void read_terms(ParamsReader& in, QueueTerms& out) {
  fields(in, out);
  if (out.failures_max < 1 || out.failures_max > kMostFailuresInRow) {
    in.refuse("failures_max", fmt::format("expected 1 to {}", kMostFailuresInRow));
  }
  if (!(out.rest_s >= 0 && out.rest_s <= kLongestRest_s)) {
    in.refuse("rest_s", fmt::format("expected 0 to {:.0f}", kLongestRest_s));
  }
  if (out.not_before_unix_s && out.not_after_unix_s &&
      *out.not_after_unix_s < *out.not_before_unix_s) {
    in.refuse("not_after_unix_s", "expected a time after not_before_unix_s");
  }
}

QueueTerms with_row_terms(QueueTerms all, const BatchTerms& row) {
  if (row.on_failure) all.on_failure = *row.on_failure;
  if (row.failures_max) all.failures_max = *row.failures_max;
  if (row.unattended) all.unattended = *row.unattended;
  if (row.rest_s) all.rest_s = *row.rest_s;
  if (row.probe) all.probe = *row.probe;
  if (row.fixture) all.fixture = *row.fixture;
  return all;
}

json to_json(const QueueTerms& terms) {
  return written(terms);
}

Result<QueueTerms> parse_terms(std::string_view json_text) {
  const json value = json::parse(json_text, nullptr, false);
  QueueTerms out;
  ParamsReader in(value, "terms");
  read_terms(in, out);
  if (auto ok = in.finish(); !ok) return fail(Errc::garbled, "{}", ok.error().what);
  return out;
}

}  // namespace lcrig
