// SPDX-License-Identifier: Apache-2.0
// Open and short corrections of LCR meters: those that lcrig made, and what is known of them at one
// time, as the row of a run, the control socket and the command line have it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/correction_kind.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

inline constexpr CorrectionKind kCorrectionKinds[] = {CorrectionKind::open,
                                                      CorrectionKind::short_circuit};

// One that the meter accepted.
struct StoredCorrection {
  CorrectionKind kind = CorrectionKind::open;
  std::string meter;  // model and serial number: what it is known by
  std::string lcr_identity;  // the reply exactly as sent
  bool simulated = false;
  std::string operator_name;
  std::int64_t operator_uid = 0;
  std::int64_t made_unix_ns = 0;
};
Result<> add_correction(const Database& db, const StoredCorrection& made);

struct CorrectionState {
  std::optional<bool> on;  // the meter applies it; none: not known
  std::optional<std::int64_t> made_unix_ns;  // the last that lcrig made; none: it made none
  std::string made_by;
};

struct MeterCorrections {
  std::string meter;  // as StoredCorrection has it
  bool simulated = false;
  CorrectionState open, short_circuit;
  CorrectionState& of(CorrectionKind kind) {
    return kind == CorrectionKind::open ? open : short_circuit;
  }
};
// Adds when and by whom the last of each kind were made with this meter, as far as the database
// knows.
Result<> look_up_corrections(const Database& db, MeterCorrections& meter);
// Those meters with which lcrig made one, the last one first. Nothing says whether they are on.
Result<std::vector<MeterCorrections>> list_corrections(const Database& db);

// {"meter":"LCR-6100 GEZ883880","simulated":false,"open":{"on":true,"made_unix_ns":…,"made_by":…},
// "short":…}; null: not known.
std::string to_json(const MeterCorrections& meter);
// nullopt: a run of an older lcrig, which knew nothing of them.
std::optional<MeterCorrections> parse_corrections(std::string_view json);

// "on, made 2026-01-31 12:00 UTC by ada (12 days before)"; `at_unix_ns`: when it was so. A date
// after that is told as one in the future: a clock was wrong.
std::string correction_words(const CorrectionState& state, std::int64_t at_unix_ns,
                             std::string_view before = "before");
bool is_in_future(const CorrectionState& state, std::int64_t at_unix_ns);
// From date to date; never negative, whatever was done to the clock.
std::int64_t days_between(std::int64_t made_unix_ns, std::int64_t at_unix_ns);

}  // namespace lcrig
