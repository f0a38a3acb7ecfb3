// SPDX-License-Identifier: Apache-2.0
// Open and short corrections of LCR meters: those that lcrig made, and the state of a meter's
// corrections at one time. Used for the row of a run, the control socket and the command line.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/meter_words.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

inline constexpr CorrectionKind kCorrectionKinds[] = {CorrectionKind::open,
                                                      CorrectionKind::short_circuit};

// A correction that the meter accepted.
struct StoredCorrection {
  CorrectionKind kind = CorrectionKind::open;
  std::string meter;  // model and serial number, which identify it
  std::string lcr_identity;  // its reply to *IDN?, exactly as sent
  bool simulated = false;
  std::string operator_name;
  std::int64_t operator_uid = 0;
  std::int64_t made_unix_ns = 0;
};
Result<> add_correction(const Database& db, const StoredCorrection& made);

struct CorrectionState {
  std::optional<bool> on;  // whether the meter applies it; none: unknown
  std::optional<std::int64_t> made_unix_ns;  // when lcrig made the latest one; none: it made none
  std::string made_by;
};

struct MeterCorrections {
  std::string meter;  // as in StoredCorrection
  bool simulated = false;
  CorrectionState open, short_circuit;
  // Of leads and fixture, as the config states it; without an open correction it is in each
  // reading.
  std::optional<double> stray_limit_F;
  CorrectionState& of(CorrectionKind kind) {
    return kind == CorrectionKind::open ? open : short_circuit;
  }
};
// Adds when and by whom the latest correction of each kind was made with this meter, as far as the
// database knows.
Result<> look_up_corrections(const Database& db, MeterCorrections& meter);
// The meters for which lcrig made a correction, the latest first. Whether they apply it is unknown.
Result<std::vector<MeterCorrections>> list_corrections(const Database& db);

// {"meter":"LCR-6100 GEZ883880","simulated":false,"open":{"on":true,"made_unix_ns":…,"made_by":…},
// "short":…}; null: unknown.
nlohmann::json to_json(const MeterCorrections& meter);
std::optional<MeterCorrections> read_corrections(const nlohmann::json& from);
// The same for RunRow::correction_json. nullopt: the run was recorded by an older lcrig, which did
// not ask for corrections.
std::optional<MeterCorrections> parse_corrections(std::string_view text);

// "on, made 2026-01-31 12:00 UTC by ada (12 days before)", where `at_unix_ns` is the time of the
// state. A later date is described as lying in the future: then a clock was wrong.
std::string correction_words(const CorrectionState& state, std::int64_t at_unix_ns,
                             std::string_view before = "before");
bool is_in_future(const CorrectionState& state, std::int64_t at_unix_ns);
// Days from one date to the other; never negative, even if the clock was set back.
std::int64_t days_between(std::int64_t made_unix_ns, std::int64_t at_unix_ns);

}  // namespace lcrig
