// SPDX-License-Identifier: Apache-2.0
// The tables of an export: their columns, and how a stored row becomes a line.
#include <cmath>
#include <span>

#include "analysis/align.hpp"
#include "analysis/export_context.hpp"
#include "analysis/frame_track.hpp"
#include "analysis/pieces.hpp"
#include "events/payloads.hpp"
#include "storage/flags.hpp"

namespace lcrig {

namespace {

constexpr Column kSeq{"seq", "integer", "", "number of the row within the run, from 1"};
constexpr Column kTime{"t_s", "number", "s", "time since the start of the run"};
constexpr Column kForce{"force_N", "number", "N", "force, compression positive"};
constexpr Column kTravel{"travel_mm", "number", "mm",
                         "machine travel, positive towards the specimen"};
constexpr Column kGap{"gap_mm", "number", "mm",
                      "distance of the probe from the last contact point, positive away from it"};
constexpr Column kPressure{"pressure_kPa", "number", "kPa", "force over the area of the probe"};
constexpr Column kStep{"step", "string", "", "id of the protocol step"};
constexpr Column kRepeat{"repeat", "integer", "", "of the outermost repeat, from 1; 0: none"};
constexpr Column kLevel{"level_in_run", "integer", "",
                        "load level within the run, from 1: of one repeat only"};
// Names of these columns in version 0.1, kept for programs that read them. The next version drops
// them (docs/export.md).
constexpr Column kOldLevel{"level", "integer", "", "the same as level_in_run; will be left out"};
constexpr Column kOldIndex{"index", "integer", "", "the same as level_in_repeat; will be left out"};
constexpr Column kReading{"reading", "integer", "", "fresh reading within the level, from 1"};
constexpr Column kFlags{"flags", "string", "", "words, separated by spaces"};
constexpr Column kReadingFlags{
    "flags", "string", "",
    "words, separated by spaces; unproven: not taken between two equal read-backs of the meter's "
    "settings (lcrig.proof has these spans), and it does not count"};
constexpr std::string_view kUnproven = "unproven";  // a word without a stored bit

// Looks up the value that is valid at an instant. The instants must not decrease.
class Follow {
 public:
  explicit Follow(const std::vector<Since>& values) : values_(values) {}
  std::optional<double> at(std::int64_t mono_ns) {
    while (next_ < values_.size() && values_[next_].mono_ns <= mono_ns) ++next_;
    if (next_ == 0) return std::nullopt;
    return values_[next_ - 1].value;
  }

 private:
  const std::vector<Since>& values_;
  std::size_t next_ = 0;
};

void join(std::int64_t flags, std::span<const std::string_view> words, std::string& out) {
  out.clear();
  for (std::size_t i = 0; i < words.size(); ++i) {
    if ((flags >> i & 1) == 0) continue;
    if (!out.empty()) out += ' ';
    out += words[i];
  }
}

// The flags of a reading, with the word for one that is not proven.
class ReadingFlags {
 public:
  explicit ReadingFlags(const ExportContext& c) : walk_(c.proof) {}
  void append(CsvWriter& out, std::int64_t flags, std::int64_t asked_mono_ns) {
    join(flags, kLcrFlagWords, words_);
    if (!walk_.is_proven(asked_mono_ns)) {
      if (!words_.empty()) words_ += ' ';
      words_ += kUnproven;
    }
    out.word(words_);
  }

 private:
  ProofWalk walk_;
  std::string words_;
};

void append_gap(CsvWriter& out, const ExportContext& c, std::optional<double> travel_m,
                std::optional<double> contact_m) {
  if (!travel_m || !contact_m) return out.empty();
  out.rounded(*contact_m - *travel_m, c.ends.travel_m, 3);
}

void append_pressure(CsvWriter& out, const ExportContext& c, std::optional<double> force_N) {
  if (!force_N || !c.area_m2) return out.empty();
  out.rounded(*force_N / *c.area_m2, c.ends.pressure_Pa, -3);
}

void append_values(CsvWriter& out, const ExportContext& c, const Statement& row, int first) {
  for (std::size_t i = 0; i < c.value_powers.size(); ++i) {
    out.number(row.optional_real(first + static_cast<int>(i)), c.value_powers[i]);
  }
}

// Runs `sql` and writes one line for each row. The first parameter is the run, then comes `more`.
template <class Line, class... Values>
Result<> for_each_row(const Database& db, const ExportContext& c, std::string_view sql,
                      CsvWriter& out, Line line, const Values&... more) {
  const auto take = [&](const Statement& row) -> Result<> {
    if (Result<> r = line(row); !r) return r;
    if (c.run.simulated) out.word("true");
    return out.end_row();
  };
  return db.each(sql, take, c.id, more...);
}

Result<> write_readings(const Database& db, const ExportContext& c, Piece piece, CsvWriter& out) {
  const auto sql = fmt::format(
      "SELECT seq, last_byte_mono_ns, asked_mono_ns, first_byte_mono_ns, step_id, repeat, level,"
      " reading_index, fresh, flags, function, status{} FROM lcr_reading WHERE run_id = ?"
      " AND seq BETWEEN ? AND ? ORDER BY seq",
      c.value_sql);
  Follow frequency(c.frequencies);
  ReadingFlags flags(c);
  return for_each_row(
      db, c, sql, out,
      [&](const Statement& row) -> Result<> {
        out.integer(row.integer(0));
        for (int i = 1; i <= 3; ++i) out.decimal(row.integer(i) - c.start_ns, -9);
        out.text(row.text(4));
        out.integer(row.integer(5));
        out.integer(row.optional_integer(6));
        out.integer(row.optional_integer(7));
        out.word(row.integer(8) != 0 ? "true" : "false");
        flags.append(out, row.integer(9), row.integer(2));
        out.word(row.text(10));
        out.number(frequency.at(row.integer(2)));
        append_values(out, c, row, 12);
        out.text(row.text(11));
        out.integer(row.optional_integer(6));
        return {};
      },
      piece.first_seq, piece.last_seq);
}

Result<> write_frame(const Database& db, const ExportContext& c, Piece piece, CsvWriter& out) {
  Follow contact(c.contacts);
  std::string scratch;
  return for_each_row(
      db, c,
      "SELECT seq, received_mono_ns, device_time_s, force_N, travel_m, flags FROM frame_sample"
      " WHERE run_id = ? AND seq BETWEEN ? AND ? ORDER BY seq",
      out,
      [&](const Statement& row) -> Result<> {
        const auto device_time = row.optional_real(2);
        const auto force = row.optional_real(3);
        const auto travel = row.optional_real(4);
        out.integer(row.integer(0));
        out.decimal(c.clock.at(row.integer(1), device_time).t_ns - c.start_ns, -9);
        out.decimal(row.integer(1) - c.start_ns, -9);
        out.number(device_time);
        out.number(force);
        out.number(travel, 3);
        append_gap(out, c, travel, contact.at(row.integer(1)));
        append_pressure(out, c, force);
        join(row.integer(5), kFrameFlagWords, scratch);
        out.word(scratch);
        return {};
      },
      piece.first_seq, piece.last_seq);
}

// Writes, in pieces by threads, the tables that grow with the run and whose rows stand alone.
Result<> write_side_by_side(const Database& db, const ExportContext& c, Layout layout,
                            CsvWriter& out) {
  const bool frame = layout == Layout::frame;
  auto last = last_seq(db, frame ? "frame_sample" : "lcr_reading", c.id);
  if (!last) return fail(last.error());
  const auto make = [&](const Database& connection, Piece piece) -> Result<std::string> {
    CsvWriter part;
    const auto r = frame ? write_frame(connection, c, piece, part)
                         : write_readings(connection, c, piece, part);
    if (!r) return fail(r.error());
    return part.take();
  };
  return in_pieces(db, *last, kPieceRows, make, [&out](const std::string& text) {
    out.rows(text);
    return out.flush();
  });
}

Result<> write_events(const Database& db, const ExportContext& c, CsvWriter& out) {
  return for_each_row(
      db, c,
      fmt::format("SELECT seq, at_mono_ns, kind, step_id, detail FROM event WHERE run_id = ? AND {}"
                  " ORDER BY seq",
                  kIsShown),
      out, [&](const Statement& row) -> Result<> {
        out.integer(row.integer(0));
        out.decimal(row.integer(1) - c.start_ns, -9);
        for (int i = 2; i <= 4; ++i) out.text(row.text(i));
        return {};
      });
}

Result<> write_answers(const Database& db, const ExportContext& c, CsvWriter& out) {
  const auto write = [&](const Statement& row) -> Result<> {
    const auto answer = from_json<AnswerEvent>(row.text(3));
    if (!answer) return fail(answer.error());
    out.integer(row.integer(0));
    out.decimal(row.integer(1) - c.start_ns, -9);
    out.text(row.text(2));
    out.integer(answer->repeat);
    out.text(answer->question);
    out.word(answer->type);
    out.number(answer->number);
    out.word(answer->unit.value_or(""));
    out.text(answer->text.value_or(""));
    out.word(answer->source);
    out.text(answer->by.value_or(""));
    out.integer(answer->from_run);
    return {};
  };
  return for_each_row(
      db, c,
      "SELECT seq, at_mono_ns, step_id, detail FROM event WHERE run_id = ? AND kind = ?"
      " ORDER BY seq",
      out, write, EventKind::answer);
}

constexpr int kUncertaintyDigits = 3;

void append_uncertainty(CsvWriter& out, const Aligned& a) {
  if (!a.state.force_N && !a.state.travel_m) {
    out.empty();
    return out.empty();
  }
  out.significant(a.uncertainty_s, kUncertaintyDigits);
  out.significant(std::abs(a.state.force_rate_N_s) * a.uncertainty_s, kUncertaintyDigits);
}

// The query's columns 0 to 3 are seq, asked, first byte and step; `write` appends the rest.
template <class Write, class... Values>
Result<> for_each_reading(const Database& db, const ExportContext& c, std::string_view sql,
                          CsvWriter& out, const Write& write, const Values&... more) {
  auto track = FrameTrack::open(db, c.id, c.hold_force, c.clock);
  if (!track) return fail(track.error());
  WindowBefore before = c.before;
  const auto line = [&](const Statement& row) -> Result<> {
    const auto a = align(*track, before.at(row.integer(1)), row.integer(1), row.integer(2));
    if (!a) return fail(a.error());
    out.integer(row.integer(0));
    out.decimal(a->middle_ns - c.start_ns, -9);
    out.text(row.text(3));
    write(row, *a);
    return {};
  };
  return for_each_row(db, c, sql, out, line, more...);
}

Result<> write_aligned(const Database& db, const ExportContext& c, CsvWriter& out) {
  const auto sql = fmt::format(
      "SELECT seq, asked_mono_ns, first_byte_mono_ns, step_id, repeat, level, reading_index, "
      "flags{}"
      " FROM lcr_reading WHERE run_id = ? AND fresh = 1 ORDER BY seq",
      c.value_sql);
  Follow contact(c.contacts);
  ReadingFlags flags(c);
  return for_each_reading(db, c, sql, out, [&](const Statement& row, const Aligned& a) {
    out.integer(row.integer(4));
    out.integer(row.optional_integer(5));
    out.integer(row.optional_integer(6));
    flags.append(out, row.integer(7), row.integer(1));
    append_values(out, c, row, 8);
    out.rounded(a.state.force_N, c.ends.force_N);
    out.rounded(a.state.travel_m, c.ends.travel_m, 3);
    append_gap(out, c, a.state.travel_m, contact.at(a.middle_ns));
    append_pressure(out, c, a.state.force_N);
    append_uncertainty(out, a);
    out.integer(row.optional_integer(5));
  });
}

// Nine digits: more than a person types, and too few for the rounding noise that a sweep adds.
void append_targets(CsvWriter& out, std::optional<double> force_N,
                    std::optional<double> pressure_Pa) {
  constexpr int kDigits = 9;
  out.significant(force_N, kDigits);
  if (pressure_Pa) *pressure_Pa *= 1e-3;
  out.significant(pressure_Pa, kDigits);
}

Result<> write_levels(const Database& db, const ExportContext& c, CsvWriter& out) {
  const auto sql = fmt::format(
      "SELECT r.seq, r.asked_mono_ns, r.first_byte_mono_ns, l.step_id, l.repeat, r.level,"
      " l.level_index, r.reading_index, l.target_force_N, l.target_pressure_Pa, r.flags{}"
      " FROM lcr_reading AS r JOIN level AS l ON l.run_id = r.run_id AND l.level = r.level"
      " WHERE r.run_id = ? AND r.reading_index IS NOT NULL AND NOT EXISTS (SELECT 1 FROM event AS e"
      " WHERE e.run_id = r.run_id AND e.kind = ?"
      " AND json_extract(e.detail, '$.level') = r.level) ORDER BY r.seq",
      c.value_sql);
  ReadingFlags flags(c);
  const auto write = [&](const Statement& row, const Aligned& a) {
    for (int i = 4; i <= 7; ++i) out.integer(row.integer(i));
    append_targets(out, row.optional_real(8), row.optional_real(9));
    out.rounded(a.state.force_N, c.ends.force_N);
    append_pressure(out, c, a.state.force_N);
    append_values(out, c, row, 11);
    flags.append(out, row.integer(10), row.integer(1));
    for (int i = 5; i <= 6; ++i) out.integer(row.integer(i));
  };
  return for_each_reading(db, c, sql, out, write, EventKind::level_abandoned);
}

void add(std::vector<Column>& to, const std::vector<Column>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

void add_reading_columns(std::vector<Column>& out, const ExportContext& c) {
  add(out, {{"t_asked_s", "number", "s", "when the reading was requested"},
            {"t_first_byte_s", "number", "s", "when the answer began"},
            kStep,
            kRepeat,
            kLevel,
            kReading,
            {"fresh", "boolean", "", "false: the meter repeated its last value"},
            kReadingFlags,
            {"function", "string", "", "impedance function of the meter"},
            {"frequency_Hz", "number", "Hz", "test frequency"}});
  add(out, c.value_columns);
  add(out, {{"status", "string", "", "comparator words as the meter sent them"}, kOldLevel});
}

void add_answer_columns(std::vector<Column>& out) {
  add(out, {kStep,
            kRepeat,
            {"question", "string", "", "what a person was asked"},
            {"type", "string", "", "of the answer: confirmation, choice, number or line"},
            {"number", "number", "", "the answer, in the unit beside it"},
            {"unit", "string", "", "of the number, as the suffix of a key; empty: a pure number"},
            {"text", "string", "", "the answer, when it is a choice or a line"},
            {"source", "string", "",
             "person, default (of the protocol), file or made_up (both in a rehearsal)"},
            {"answered_by", "string", "", "the person"},
            {"from_run", "integer", "", "it was answered in that run, which this one continues"}});
}

}  // namespace

std::vector<Column> columns_of(const ExportContext& c, Layout layout) {
  std::vector<Column> out{kSeq, kTime};
  switch (layout) {
    case Layout::readings: add_reading_columns(out, c); break;
    case Layout::frame:
      out.back().description =
          "when the sample was taken, since the start of the run: by the frame's clock, else of "
          "arrival";
      add(out, {{"t_received_s", "number", "s", "when it arrived, since the start of the run"},
                {"device_time_s", "number", "s", "the frame's own clock"},
                kForce,
                kTravel,
                kGap,
                kPressure,
                kFlags});
      break;
    case Layout::levels:
      add(out, {kStep,
                kRepeat,
                kLevel,
                {"level_in_repeat", "integer", "",
                 "of the level within its repeat, from 1: the same load in every repeat"},
                kReading,
                {"target_force_N", "number", "N", "force asked for"},
                {"target_pressure_kPa", "number", "kPa",
                 "pressure asked for, as force over the area of the probe"},
                kForce,
                kPressure});
      add(out, c.value_columns);
      add(out, {kReadingFlags, kOldLevel, kOldIndex});
      break;
    case Layout::events:
      add(out, {{"kind", "string", "", "what happened"},
                kStep,
                {"detail", "string", "", "text, or JSON for kinds that carry numbers"}});
      break;
    case Layout::aligned:
      add(out, {kStep, kRepeat, kLevel, kReading, kReadingFlags});
      add(out, c.value_columns);
      add(out, {kForce,
                kTravel,
                kGap,
                kPressure,
                {"alignment_uncertainty_s", "number", "s", "standard uncertainty of the instant"},
                {"alignment_uncertainty_N", "number", "N", "the same times the rate of force"},
                kOldLevel});
      break;
    case Layout::answers: add_answer_columns(out); break;
  }
  if (c.run.simulated) {
    out.push_back(
        {"simulated", "boolean", "", "true: the bench was simulated, nothing was measured"});
  }
  return out;
}

Result<> write_layout(const Database& db, const ExportContext& c, Layout layout, CsvWriter& out) {
  for (const Column& column : columns_of(c, layout)) out.word(column.name);
  if (auto r = out.end_row(); !r) return r;
  Result<> written;
  switch (layout) {
    case Layout::readings:
    case Layout::frame: written = write_side_by_side(db, c, layout, out); break;
    case Layout::levels: written = write_levels(db, c, out); break;
    case Layout::events: written = write_events(db, c, out); break;
    case Layout::aligned: written = write_aligned(db, c, out); break;
    case Layout::answers: written = write_answers(db, c, out); break;
  }
  if (!written) return written;
  return out.flush();
}

}  // namespace lcrig
