// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/batch.hpp"

namespace lcrig {

namespace {

std::optional<std::int64_t> positive(std::int64_t value) {
  if (value <= 0) return std::nullopt;
  return value;
}

// The value columns of lcr_reading. The meter's function decides which two are filled.
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
  // Read each time, because another connection may have added a note.
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
  levels_->begin(hash_).add(run, seq, l.level, l.step_id, l.repeat, l.index, l.target_force_N);
  return levels_->add(l.target_pressure_Pa, l.planned_readings, l.begin).insert();
}

Result<> BatchWriter::write_event(std::int64_t run, std::int64_t seq, const RunEvent& e) {
  return events_->begin(hash_).add(run, seq, e.t, e.kind.word(), e.step_id, e.detail).insert();
}

Result<> BatchWriter::write_reading(std::int64_t run, std::int64_t seq,
                                    const Batch::TaggedReading& row) {
  const auto& [r, tag] = row;
  const Values v = values_of(r);
  RowWriter& w = readings_->begin(hash_);
  w.add(run, seq, r.asked, r.first_byte, r.last_byte, tag.planned, tag.step_id, tag.repeat);
  w.add(positive(tag.level), positive(tag.index), r.fresh, r.flags, to_string(r.function));
  w.add(r.status, v.capacitance, v.dissipation, v.resistance, v.reactance, v.impedance);
  return w.add(v.phase_rad, v.phase_deg).insert();
}

Result<> BatchWriter::write_sample(std::int64_t run, std::int64_t seq, const FrameSample& s) {
  samples_->begin(hash_).add(run, seq, s.received, s.device_seq, s.device_time_s, s.force_N);
  return samples_->add(s.travel_m, s.flags).insert();
}

Result<> BatchWriter::write_end(std::int64_t run, const RunEnd& end) {
  ends_->begin(hash_).add(run, to_string(end.status), end.reason, end.ended, end.ended_unix_ns);
  return ends_->insert();
}

}  // namespace lcrig
