// SPDX-License-Identifier: Apache-2.0
// Reads the meter for a run: continuously in the background while steps run, and at planned times
// for `measure`. One exchange at a time. Reads its settings back: when anything gives a reason to,
// regularly between readings, and at the ends of levels, of settings and of the run.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <functional>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "drivers/lcr_meter.hpp"
#include "protocols/run/settings_proof.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

class Sampler {
 public:
  struct Hooks {
    std::function<ReadingTag()> tag;  // for a background reading
    std::function<void(const LcrReading&, const ReadingTag&)> taken;
    std::function<void(EventKind kind, std::string detail)> event;
    std::function<void(Error)> lost;  // the meter cannot be read any more, or has other settings
    std::function<void(const ReadBackEvent&)> read_back;
    std::function<void(const UnprovenEvent&)> unproven;
  };
  Sampler(asio::any_io_executor executor, Clock& clock, LcrMeter& lcr, MeterState state,
          Hooks hooks);

  void start(bool continuous);
  // Ends the background readings after the current exchange, or at once if that takes too long.
  Task<> stop();
  // Reads the settings back. Errors: they differ, or the meter does not answer.
  Task<Result<>> prove();
  // The same before the next reading.
  void doubt() { proof_.doubt(); }
  // Whether a reading asked at or after this time turned out to be unproven.
  bool is_spoiled(MonoTime since) const { return proof_.is_spoiled(since); }
  // Ends the proof: the readings that cannot be proven any more are unproven.
  Task<> finish_proof();

  struct Plan {
    Plan() = default;
    LoadLevel level;
    Duration within{};
  };
  // Takes the readings first+1 .. planned_readings of a level at planned times. `taken` is always
  // up to date, so that the call can be repeated after a cancellation. Errors: why it failed.
  Task<Result<>> take(const Plan& plan, std::int64_t& taken);
  Task<Result<>> configure(LcrSettings settings);
  // One attempt after `lost`, which brings the settings back; `start` then resumes. Errors: as
  // LcrMeter::reconnect.
  Task<Result<>> reconnect();
  // Words when somebody has waited for a reading longer than any answer can take.
  std::optional<std::string> check_age(MonoTime now) const;
  // Ends the current exchange of the background readings.
  void interrupt();
  bool is_running() const { return running_; }  // whether background readings run
  // For the watchdog: the number of exchanges so far, when the current one takes longer than any
  // time-out of a driver.
  std::optional<std::uint64_t> overdue(MonoTime now) const;
  const LcrSettings& settings() const { return state_.settings; }

 private:
  using Token = asio::experimental::channel<void(boost::system::error_code)>;
  class Lock;
  class Exchange;

  Task<> background();
  Task<Result<LcrReading>> read_once();
  Task<Result<ReadBack>> ask_back();
  Task<Result<>> compare();
  Task<Result<>> compare_surely();
  Task<Result<>> compare_before(MonoTime due);
  Task<Result<>> settle_doubt();
  Task<Result<>> end_slowness();
  Task<Result<LcrSettings>> bring_back();
  Result<> judge(const ReadBack& found);
  bool is_lost(const Error& error) const;
  Task<Result<>> take_one(const Plan& plan, MonoTime due, std::int64_t& taken);
  void store(const LcrReading& reading, const ReadingTag& tag);
  Result<> lose(Error error);
  Task<> acquire();
  void release();

  asio::any_io_executor executor_;
  Clock& clock_;
  LcrMeter& lcr_;
  MeterState state_;
  Hooks hooks_;
  SettingsProof proof_;
  Token meter_;  // holds one token while the meter is free
  Token ended_;
  asio::cancellation_signal cancel_;
  bool running_ = false, ending_ = false;
  int failures_ = 0;  // consecutive failures
  std::string last_failure_;  // ": " and why the last reading was not taken
  std::optional<MonoTime> waiting_;  // since the last good reading, while somebody reads
  bool interrupted_ = false;
  bool half_set_ = false;  // a configuration was cut off, so readings mean nothing
  std::uint32_t next_flags_ = 0;  // of the next reading
  bool slow_ = false;  // the last reading says so
  bool astray_ = false;  // the meter answers, with other settings
  std::uint64_t exchanges_ = 0;
  std::optional<MonoTime> exchange_;  // start of the current exchange
};

}  // namespace lcrig
