// SPDX-License-Identifier: Apache-2.0
// Makes the open and the short correction of the meter for a person, and stores who made it and
// when. Owned by MeterRequests, which keeps others from using the rig meanwhile.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "base/task.hpp"
#include "daemon/control/messages.hpp"
#include "drivers/lcr_meter.hpp"
#include "storage/corrections.hpp"

namespace lcrig {

class InstrumentFactory;
class KnownRig;

// The name of a meter, whatever its firmware: "LCR-6100 GEZ883880".
std::string meter_name(const Identity& identity);
// The result does not contain the dates of the corrections.
MeterCorrections corrections_of(const Identity& identity, bool simulated, const CorrectionsOn& on);

class Corrector {
 public:
  // References; all must outlive it.
  struct Parts {
    asio::any_io_executor executor;
    Clock& clock;
    InstrumentFactory& rig;
    KnownRig& known;
    const std::string& database;
    const std::string& vfs;  // SQLite's VFS for the database
    std::int64_t bytes = 1 << 20;  // disk space that a correction must find before it is made
  };
  explicit Corrector(const Parts& parts) : parts_(parts) {}

  // Call after a person has prepared the probes. Returns the corrections that are on then, with
  // their dates. Errors: those of port and meter; refused (the meter's own verdict); io: no room on
  // the disk, or the correction was made but not stored, as the words say.
  Task<Result<MeterCorrections>> make(CorrectionKind kind, PeerCredentials peer);
  // Asks the meter which corrections it applies.
  Task<Result<MeterCorrections>> look();
  // Call when the daemon ends: nobody waits for the meter any more.
  void give_up();

 private:
  Task<Result<MeterCorrections>> correct_if_room(CorrectionKind kind);
  // Without a kind, only asks.
  Task<Result<MeterCorrections>> with_meter(std::optional<CorrectionKind> kind);
  Task<Result<MeterCorrections>> use(LcrMeter& meter, std::optional<CorrectionKind> kind);
  Task<Result<Identity>> identify(LcrMeter& meter);
  Task<Result<>> correct(LcrMeter& meter, CorrectionKind kind);

  Parts parts_;
  LcrMeter* in_use_ = nullptr;
  std::string identity_;  // of the last meter used
  bool given_up_ = false;
};

}  // namespace lcrig
