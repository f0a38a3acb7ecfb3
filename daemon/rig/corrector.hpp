// SPDX-License-Identifier: Apache-2.0
// Makes the open and the short correction of the meter for a person, and stores who made them when.
// App has one, and sees to it that nobody else uses the rig meanwhile.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "daemon/control/messages.hpp"
#include "daemon/rig/instruments.hpp"
#include "storage/corrections.hpp"

namespace lcrig {

// What a meter is known by, whatever its firmware: "LCR-6100 GEZ883880".
std::string meter_name(const Identity& identity);
// When they were made is not in it.
MeterCorrections corrections_of(const Identity& identity, bool simulated, const CorrectionsOn& on);

class Corrector {
 public:
  // All outlive it.
  struct Parts {
    asio::any_io_executor executor;
    Clock& clock;
    InstrumentFactory& rig;
    KnownRig& known;
    const std::string& database;
    const std::string& vfs;  // of SQLite, for the database
    std::int64_t bytes = 1 << 20;  // that storing one may take: the disk has room for it, or none
                                   // is made
  };
  explicit Corrector(const Parts& parts) : parts_(parts) {}

  // The person has prepared the probes. Returns what is on then, and when it was made. Errors: what
  // port and meter say; refused (the meter's own verdict); io: the disk has no room for it, or it
  // was made, but is not stored, as the words say.
  Task<Result<MeterCorrections>> make(CorrectionKind kind, PeerCredentials peer);
  // Asks the meter which ones it applies.
  Task<Result<MeterCorrections>> look();
  // The daemon ends: nobody waits for the meter any more.
  void give_up();

 private:
  Task<Result<MeterCorrections>> correct_if_room(CorrectionKind kind);
  // Without a kind it is only asked.
  Task<Result<MeterCorrections>> with_meter(std::optional<CorrectionKind> kind);
  Task<Result<MeterCorrections>> use(LcrMeter& meter, std::optional<CorrectionKind> kind);
  Task<Result<Identity>> identify(LcrMeter& meter);
  Task<Result<>> correct(LcrMeter& meter, CorrectionKind kind);

  Parts parts_;
  LcrMeter* in_use_ = nullptr;
  std::string identity_;  // of the meter that was used last
  bool given_up_ = false;
};

}  // namespace lcrig
