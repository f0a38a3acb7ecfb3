// SPDX-License-Identifier: Apache-2.0
// The interface of every LCR meter. Protocols and daemon know the instrument only through it.
// Drivers implement it, and simulators answer the drivers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/flags.hpp"
#include "base/meter_words.hpp"
#include "base/quantity.hpp"
#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "drivers/identity.hpp"
#include "events/payloads.hpp"

namespace lcrig {

struct LcrSettings {
  LcrFunction function = LcrFunction::CpD;
  Frequency frequency = Frequency::from_si(1000);
  Voltage level = Voltage::from_si(1);
  std::optional<Voltage> bias;  // absent: OFF
  Aperture aperture = Aperture::medium;
  int average = 1;
  LcrTrigger trigger = LcrTrigger::bus;
  // Internal trigger only: the pause between polls. When absent, the driver follows the meter's
  // pace.
  std::optional<Duration> poll_interval;
  bool operator==(const LcrSettings&) const = default;
};
// The settings as stored in run rows and events. The analysis needs the conversion time to know
// when a polled reading was measured.
SettingsEvent settings_event(const LcrSettings& settings, Duration conversion_time);

struct LcrCapabilities {
  std::vector<LcrFunction> functions;
  Frequency frequency_min, frequency_max;
  Voltage level_min, level_max;
  Voltage bias_min, bias_max;
  int average_max = 1;
  // Time of one conversion without averaging, by aperture (fast, medium, slow).
  Duration conversion[3] = {};
  Duration conversion_time(const LcrSettings& s) const;  // with averaging
  // After a change of a setting, values may still be taken at the old one for this long.
  Duration settling{};
  Duration read_back{};  // time that LcrMeter::read_back takes
  // For a meter with internal trigger that answers at once: how much later after its conversion
  // each value is found than the one before, and how much earlier the driver asks again after that
  // (Pace::kLater and kEarlier).
  Duration found_later{}, found_earlier{};
};

struct LcrReading {
  std::optional<double> primary;  // coherent SI: F for the C functions, ohm for R-X and Z
  std::optional<double>
      secondary;  // coherent SI: 1 for D, ohm for R, X; rad for thr, degree for thd
  LcrFunction function = LcrFunction::CpD;
  std::uint32_t flags = 0;
  bool fresh = true;  // false: the meter repeated its last value (internal trigger)
  bool slow = false;  // several in a row took much longer than the settings say
  std::string status;  // comparator words as sent ("OUT ,AUX-NG,NG"); they are not validity
  MonoTime asked, first_byte, last_byte;
};

// nullopt: the meter cannot tell.
struct CorrectionsOn {
  std::optional<bool> open, short_circuit;
};

// All that a value depends on.
struct MeterState {
  MeterState(LcrSettings s, CorrectionsOn c = {}) : settings(std::move(s)), corrections(c) {}
  LcrSettings settings;
  CorrectionsOn corrections;  // nullopt: whichever
};

// What a meter answered to the questions for its state.
struct ReadBack {
  bool equal() const { return differs.empty(); }
  std::vector<std::string> differs;  // the settings that were not as wanted, by their keys
};
struct Reconnected {
  Reconnected(LcrSettings s, ReadBack f) : settings(std::move(s)), found(std::move(f)) {}
  LcrSettings settings;  // as read back
  ReadBack found;  // before anything was sent
};

class LcrMeter {
 public:
  virtual ~LcrMeter() = default;
  virtual const LcrCapabilities& capabilities() const = 0;
  virtual Task<Result<Identity>> identify() = 0;
  // Sends every setting, reads each back, retries lost ones, and waits until they have settled.
  // Returns the settings as read back. Fails with the difference when the meter does not take one.
  virtual Task<Result<LcrSettings>> configure(LcrSettings settings) = 0;
  // As configure, for a meter that was configured before. May send only the settings that differ,
  // but reads all of them back.
  virtual Task<Result<LcrSettings>> restore(MeterState wanted);
  // Compares the state with the one wanted by the cheapest queries that reveal it. Sends no
  // setting. An answer that differs is asked for again on an emptied line, because it may be an old
  // one. Errors: a question was not answered.
  virtual Task<Result<ReadBack>> read_back(MeterState wanted) = 0;
  // One reading with the current settings: a new conversion (bus trigger), or the next answer to a
  // poll (internal trigger; check `fresh`).
  virtual Task<Result<LcrReading>> measure() = 0;
  // Measures an open or short correction, after a person has prepared the fixture, and switches it
  // on. Takes minutes. The meter has to be configured again. Errors: refused (the meter's own
  // verdict, or it does not switch the correction on); after any other error it may still be busy.
  virtual Task<Result<>> correct(CorrectionKind kind) = 0;
  // Which corrections the meter applies now.
  virtual Task<Result<CorrectionsOn>> corrections();
  // Call after a cancelled or failed exchange, so that no late answer is taken for a later one.
  virtual Task<Result<>> resync() = 0;
  // Leaves the meter ready for use by hand: continuous trigger, keys unlocked.
  virtual Task<Result<>> make_safe() = 0;
  // One attempt to bring back a lost meter in the state wanted (reopening.hpp). Errors:
  // refused (another instrument answers), invalid_request (there is nothing to reopen); any other
  // error means that it is not there yet.
  virtual Task<Result<Reconnected>> reconnect(MeterState wanted);
  virtual void close() = 0;
};

}  // namespace lcrig
