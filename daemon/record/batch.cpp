// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/batch.hpp"

#include "storage/flags.hpp"

namespace lcrig {

namespace {

static_assert(kLcrFlagWords[0] == "overload_primary" && lcr_flag::kPrimaryOverload == 1U << 0U);
static_assert(kLcrFlagWords[1] == "overload_secondary" && lcr_flag::kSecondaryOverload == 1U << 1U);
static_assert(kLcrFlagWords[2] == "after_resync" && lcr_flag::kAfterResync == 1U << 2U);
static_assert(kLcrFlagWords[3] == "after_set_up" && lcr_flag::kAfterSetUp == 1U << 3U);
static_assert(kLcrFlagWords[4] == "after_gap" && lcr_flag::kAfterGap == 1U << 4U);
static_assert(kFrameFlagWords[0] == "moving" && frame_flag::kMoving == 1U << 0U);
static_assert(kFrameFlagWords[1] == "force_control" && frame_flag::kForceControl == 1U << 1U);
static_assert(kFrameFlagWords[2] == "force_overload" && frame_flag::kForceOverload == 1U << 2U);
static_assert(kFrameFlagWords[3] == "after_gap" && frame_flag::kAfterGap == 1U << 3U);
static_assert(frame_flag::kAfterGap == kFrameAfterGap);

std::int64_t ns(MonoTime t) {
  return t.time_since_epoch().count();
}
std::optional<std::int64_t> positive(std::int64_t value) {
  if (value <= 0) return std::nullopt;
  return value;
}

// The value columns of lcr_reading: the function says which two are meant.
struct Values {
  std::optional<double> capacitance, dissipation, resistance, reactance, impedance, phase_rad,
      phase_deg;
};
Values values_of(const LcrReading& r) {
  Values v;
  switch (r.function) {
    case LcrFunction::CsRs:
    case LcrFunction::CpRp: v.capacitance = r.primary, v.resistance = r.secondary; break;
    case LcrFunction::CsD:
    case LcrFunction::CpD: v.capacitance = r.primary, v.dissipation = r.secondary; break;
    case LcrFunction::RX: v.resistance = r.primary, v.reactance = r.secondary; break;
    case LcrFunction::ZThr: v.impedance = r.primary, v.phase_rad = r.secondary; break;
    case LcrFunction::ZThd: v.impedance = r.primary, v.phase_deg = r.secondary; break;
  }
  return v;
}

Result<> prepare_into(const Database& db, std::string_view table, std::optional<RowWriter>& out) {
  auto writer = RowWriter::prepare(db, table);
  if (!writer) return fail(writer.error());
  out.emplace(std::move(*writer));
  return {};
}

}  // namespace

void Batch::clear() {
  levels.clear();
  events.clear();
  readings.clear();
  samples.clear();
  oldest.reset();
}

Result<BatchWriter> BatchWriter::prepare(const Database& db) {
  BatchWriter w;
  if (auto r = prepare_into(db, "level", w.levels_); !r) return fail(r.error());
  if (auto r = prepare_into(db, "event", w.events_); !r) return fail(r.error());
  if (auto r = prepare_into(db, "lcr_reading", w.readings_); !r) return fail(r.error());
  if (auto r = prepare_into(db, "frame_sample", w.samples_); !r) return fail(r.error());
  if (auto r = prepare_into(db, "run_end", w.ends_); !r) return fail(r.error());
  auto chain = ChainWriter::prepare(db);
  if (!chain) return fail(chain.error());
  w.chain_.emplace(std::move(*chain));
  return w;
}

Result<> BatchWriter::write(const Database& db, std::int64_t run, const Batch& batch,
                            const RunEnd* end) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  // Read anew each time: a note may have been added by another connection.
  auto head = chain_->head(run);
  if (!head) return fail(head.error());
  Batch nothing;
  const bool already_there = head->hash == failed_attempt_;
  const Batch& rows = already_there ? nothing : batch;
  if (rows.rows() == 0 && (end == nullptr || head->ended)) return {};
  hash_.start(head->hash);
  if (auto r = write_rows(run, rows, *head); !r) return r;
  if (end != nullptr) {
    if (auto r = write_end(run, *end); !r) return r;
    head->ended = true;
  }
  if (auto r = chain_->append(*head, hash_); !r) return r;
  if (end != nullptr) {
    if (auto r = chain_->anchor(*head); !r) return r;
  }
  failed_attempt_ = head->hash;
  if (auto r = transaction->commit(); !r) return r;
  failed_attempt_.reset();
  return {};
}

Result<> BatchWriter::write_rows(std::int64_t run, const Batch& batch, ChainHead& head) {
  for (const LoadLevel& row : batch.levels) {
    if (auto r = write_level(run, ++head.last_of(RunTable::level), row); !r) return r;
  }
  for (const RunEvent& row : batch.events) {
    if (auto r = write_event(run, ++head.last_of(RunTable::event), row); !r) return r;
  }
  for (const auto& row : batch.readings) {
    if (auto r = write_reading(run, ++head.last_of(RunTable::lcr_reading), row); !r) return r;
  }
  for (const FrameSample& row : batch.samples) {
    if (auto r = write_sample(run, ++head.last_of(RunTable::frame_sample), row); !r) return r;
  }
  return {};
}

Result<> BatchWriter::write_level(std::int64_t run, std::int64_t seq, const LoadLevel& l) {
  levels_->begin(hash_).add(run).add(seq).add(l.level).add(l.step_id).add(l.repeat).add(l.index);
  levels_->add(l.target_force_N).add(l.target_pressure_Pa).add(l.planned_readings).add(ns(l.begin));
  return levels_->insert();
}

Result<> BatchWriter::write_event(std::int64_t run, std::int64_t seq, const RunEvent& e) {
  events_->begin(hash_)
      .add(run)
      .add(seq)
      .add(ns(e.t))
      .add(e.kind.word())
      .add(e.step_id)
      .add(e.detail);
  return events_->insert();
}

Result<> BatchWriter::write_reading(std::int64_t run, std::int64_t seq,
                                    const Batch::TaggedReading& row) {
  const auto& [r, tag] = row;
  std::optional<std::int64_t> planned;
  if (tag.planned) planned = ns(*tag.planned);
  const Values v = values_of(r);
  RowWriter& w = readings_->begin(hash_);
  w.add(run).add(seq).add(ns(r.asked)).add(ns(r.first_byte)).add(ns(r.last_byte)).add(planned);
  w.add(tag.step_id).add(tag.repeat).add(positive(tag.level)).add(positive(tag.index));
  w.add(std::int64_t{r.fresh ? 1 : 0}).add(std::int64_t{r.flags}).add(to_string(r.function));
  w.add(r.status).add(v.capacitance).add(v.dissipation).add(v.resistance).add(v.reactance);
  w.add(v.impedance).add(v.phase_rad).add(v.phase_deg);
  return w.insert();
}

Result<> BatchWriter::write_sample(std::int64_t run, std::int64_t seq, const FrameSample& s) {
  samples_->begin(hash_).add(run).add(seq).add(ns(s.received)).add(s.device_seq);
  samples_->add(s.device_time_s).add(s.force_N).add(s.travel_m).add(std::int64_t{s.flags});
  return samples_->insert();
}

Result<> BatchWriter::write_end(std::int64_t run, const RunEnd& end) {
  std::optional<std::int64_t> ended;
  if (end.ended) ended = ns(*end.ended);
  ends_->begin(hash_).add(run).add(to_string(end.status)).add(end.reason);
  ends_->add(ended).add(end.ended_unix_ns);
  return ends_->insert();
}

}  // namespace lcrig
