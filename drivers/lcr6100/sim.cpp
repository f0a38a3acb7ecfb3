// SPDX-License-Identifier: Apache-2.0
#include "drivers/lcr6100/sim.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/clock.hpp"
#include "drivers/lcr6100/sim_values.hpp"

namespace lcrig::lcr6100 {

namespace {
using namespace std::chrono_literals;

constexpr std::string_view kWords = ",OUT ,AUX-NG,NG";  // the comparator has no limits
constexpr std::size_t kMaxLine = 1000;  // bytes; the receive buffer of the related AT381x
constexpr Duration kWriteTime = 5s;
constexpr Duration kSweepTime = 20s;
constexpr double kLeads_F = 0.32e-12;  // stray of a good wiring, LCR reference 5
}  // namespace

Lcr6100Sim::Lcr6100Sim(std::unique_ptr<Transport> transport, Clock& clock, SimConfig config,
                       Source source)
    : transport_(std::move(transport)),
      clock_(clock),
      config_(std::move(config)),
      source_(std::move(source)),
      noise_(config_.seed),
      grid_start_(clock.now()) {
  reset();
}

Lcr6100Sim::Lcr6100Sim(std::unique_ptr<Transport> transport, Clock& clock, SimConfig config,
                       Recording recording)
    : Lcr6100Sim(std::move(transport), clock, std::move(config), Source()) {
  recording_ = std::move(recording);
}

void Lcr6100Sim::attach(std::unique_ptr<Transport> transport) {
  transport_ = std::move(transport);
  in_.clear();
}

void Lcr6100Sim::keep_settings_of(const Lcr6100Sim& before) {
  values_ = before.values_;
  aperture_ = before.aperture_;
  average_ = before.average_;
  in_force_ = before.in_force_;
  before_ = before.before_;
  error_ = before.error_;
  garbage_sent_ = before.garbage_sent_;
  epoch_ = before.epoch_ + 1;
  hooks_ = before.hooks_;
}

void Lcr6100Sim::power_on(std::string identity) {
  if (!identity.empty()) config_.identity = std::move(identity);
  reset();
  error_ = "*E00";
  garbage_sent_ = false;
  ++starts_;
  restart_grid();
  reading_.clear();
  monitors_.clear();
}

Task<> Lcr6100Sim::run() {
  std::array<char, 512> chunk{};
  while (true) {
    const bool streaming = faults_.streaming && internal();
    const MonoTime deadline = streaming ? next_edge() : MonoTime::max();
    auto n = co_await transport_->read_some(chunk, deadline);
    if (n) {
      co_await take(std::string_view(chunk.data(), *n));
    } else if (n.error().code == Errc::no_reply) {
      co_await stream();
    } else {
      co_return;
    }
  }
}

Task<> Lcr6100Sim::take(std::string_view bytes) {
  if (faults_.off) co_return;
  in_ += bytes;
  std::size_t begin = 0;
  for (auto end = in_.find('\n'); end != in_.npos; end = in_.find('\n', begin)) {
    std::string_view text = std::string_view(in_).substr(begin, end - begin);
    if (text.ends_with('\r')) text.remove_suffix(1);
    begin = end + 1;
    co_await line(text);
  }
  in_.erase(0, begin);
  if (in_.size() > kMaxLine) {
    in_.clear();
    fail_with("*E04");
  }
}

// One message: commands joined by ';'. Each continues on the header path of the one before.
Task<> Lcr6100Sim::line(std::string_view text) {
  path_.clear();
  if (value("SYST:SHAK").word == "ON" && !text.empty()) co_await answer(std::string(text));
  while (!text.empty()) {
    const auto end = std::min(text.find(';'), text.size());
    co_await command(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (value("SYST:CODE").word == "ON") co_await answer(error_);
  }
}

// Sends one line, with the faults that tests or scripts requested.
Task<> Lcr6100Sim::answer(std::string text) {
  if (faults_.silent || faults_.off) co_return;
  SimFaults::Reply fault(SimFaults::Kind::none);
  if (!faults_.replies.empty()) {
    fault = faults_.replies.front();
    faults_.replies.pop_front();
  } else if (hooks_.answer) {
    fault = hooks_.answer();
  }
  using Kind = SimFaults::Kind;
  if (fault.kind == Kind::drop) co_return;
  const int start = starts_;
  if (fault.delay > 0s) co_await clock_.wait_for(fault.delay);
  if (faults_.off || start != starts_) co_return;  // it was switched off meanwhile
  out_.clear();
  if (!std::exchange(garbage_sent_, true)) out_ = faults_.first_line;
  if (fault.kind == Kind::echo) out_.append("FETC?\r\n");
  if (fault.kind == Kind::cut) {
    out_.append(text, 0, text.size() / 2);
  } else {
    out_.append(spoiled(text + "\r\n", fault.kind));
  }
  noise_.spoil(out_, faults_.byte_noise);
  auto written = co_await transport_->write_all(out_, clock_.now() + kWriteTime);
  static_cast<void>(written);  // a meter does not notice whether anybody listens
}

Task<> Lcr6100Sim::speak(std::string text) {
  if (faults_.silent || faults_.off) co_return;
  if (text.empty()) {
    if (reading_.empty()) co_return;
    tell();
    text = reading_ + std::string(kWords);
  }
  const std::string line = text + "\r\n";
  auto written = co_await transport_->write_all(line, clock_.now() + kWriteTime);
  static_cast<void>(written);
}

Duration Lcr6100Sim::conversion() const {
  const double once = config_.conversion_s[static_cast<std::size_t>(aperture_)];
  return from_seconds(once * average_ * faults_.slow_factor);
}

// Called when a setting changes. As in the meter, the last finished value stays readable until the
// first conversion under the new setting ends.
void Lcr6100Sim::restart_grid() {
  if (!recording_ && internal() && finished() > 0 && finished() != computed_) {
    compute(grid_start_ + finished() * conversion() - conversion() / 2, finished());
  }
  grid_start_ = clock_.now();
  computed_ = 0;
  streamed_ = 0;
  ++epoch_;
}

double Lcr6100Sim::sigma(const SimSettings& s) const {
  return config_.capacitance_noise_F[s.aperture] * (1000 / s.frequency_Hz) / s.level_V /
         std::sqrt(s.average);
}

const SimSettings& Lcr6100Sim::in_force(MonoTime t) const {
  const auto later = [t](const auto& entry) { return entry.first > t; };
  const auto first = std::ranges::find_if(in_force_, later);
  return first == in_force_.begin() ? first->second : std::prev(first)->second;
}

// The settings that are answered become those of the measurement now, or later.
void Lcr6100Sim::note_settings(double late_s) {
  constexpr std::size_t kKept = 64;
  SimSettings now = settings_now();
  if (!in_force_.empty() && in_force_.back().second == now) return;
  MonoTime since = clock_.now() + from_seconds(late_s);
  if (!in_force_.empty()) since = std::max(since, in_force_.back().first);
  in_force_.emplace_back(since, std::move(now));
  if (in_force_.size() > kKept) in_force_.pop_front();
}

// Computes the conversion whose window is centred on `middle`.
void Lcr6100Sim::compute(MonoTime middle, std::int64_t index) {
  computed_ = index;
  if (faults_.stuck && !reading_.empty()) return;
  const SimSettings& s = in_force(middle);
  const Duration half = conversion() / 2;
  measured_at_.reset();
  if (in_force(middle - half) == in_force(middle + half)) measured_at_ = s;
  Electrical e = source_(middle);
  // A person switched the correction on because of the leads.
  if (config_.corrected && !s.open_correction) e.capacitance_F += kLeads_F;
  const BasicAccuracy allowed = basic_accuracy(s.aperture == 0, s.frequency_Hz, s.level_V);
  e.capacitance_F *= 1 + config_.gain_error * allowed.gain;
  e.capacitance_F += config_.offset_error * allowed.offset_F;
  const auto [first, second] = noise_pair(config_.seed, epoch_, index);
  const double noise = sigma(s);
  if (e.capacitance_F > 0) e.dissipation += noise / e.capacitance_F * second;
  e.capacitance_F += noise * first;
  if (faults_.overload) e.capacitance_F = std::nan("");
  const Impedance z(e.capacitance_F, e.dissipation, s.frequency_Hz);
  const std::string_view function = s.function;
  const auto dash = function.find('-');
  reading_.clear();
  append_value(reading_, function.substr(0, dash), z.value(function.substr(0, dash)));
  if (dash != function.npos) {
    reading_ += ',';
    append_value(reading_, function.substr(dash + 1), z.value(function.substr(dash + 1)));
  }
  monitors_.clear();
  for (const char* header : {"FUNC:MON1", "FUNC:MON2"}) {
    const std::string& word = value(header).word;
    if (word == "OFF") continue;
    monitors_ += ',';
    double shown = z.value(word);
    if (word == "VAC") shown = s.level_V;
    if (word == "IAC") shown = s.level_V / z.value("Z");
    append_value(monitors_, word, shown);
  }
}

std::size_t Lcr6100Sim::compute_recorded() {
  if (!play_start_) play_start_ = clock_.now();
  auto row = recording_(clock_.now() - *play_start_, conversion());
  if (row.number > 0) reading_ = std::move(row.text);
  return row.number;
}

// Returns when an answer is there that comes after the first `after` ones, or none comes for long.
Task<> Lcr6100Sim::await_recorded(std::size_t after) {
  constexpr Duration kStep = 1ms, kLongest = 5s;
  const MonoTime limit = clock_.now() + kLongest;
  while (compute_recorded() <= after && clock_.now() < limit) co_await clock_.wait_for(kStep);
}

// All forms of FETC?: answers the latest finished conversion and waits for the first one.
Task<> Lcr6100Sim::fetch(std::string_view what) {
  ++fetches_;
  if (recording_) {
    co_await await_recorded(0);
  } else if (internal()) {
    if (reading_.empty() && finished() == 0) co_await clock_.wait_until(next_edge());
    const std::int64_t k = finished();
    if (k > 0 && k != computed_) compute(grid_start_ + k * conversion() - conversion() / 2, k);
  }
  if (reading_.empty()) co_return;  // bus trigger, and nothing was triggered yet
  if (what == ":MON") {
    if (monitors_.empty()) co_return;
    std::string text = monitors_.substr(1);
    co_await answer(std::move(text));
    co_return;
  }
  tell();
  std::string text = reading_;
  if (what == ":IMP") text += monitors_;
  if (what != ":MAIN") text += text.find(',') == text.npos ? ",OUT ,OK" : kWords;
  co_await answer(std::move(text));
}

Task<> Lcr6100Sim::trigger(bool answered) {
  if (internal()) {
    fail_with("*E02");
    co_return;
  }
  const MonoTime begin = clock_.now();
  const Duration time = conversion();
  const int start = starts_;
  if (recording_) compute_recorded();  // starts it
  co_await clock_.wait_until(begin + time);
  if (faults_.off || start != starts_) co_return;
  if (recording_) {
    // Only a reading that arrives from now on was measured after the trigger.
    const std::size_t before = compute_recorded();
    co_await await_recorded(before);
  } else {
    compute(begin + time / 2, computed_ + 1);
  }
  if (!answered || reading_.empty()) co_return;
  tell();
  std::string text = reading_;
  text += text.find(',') == text.npos ? ",OUT ,OK" : kWords;
  co_await answer(std::move(text));
}

Task<> Lcr6100Sim::stream() {
  const std::int64_t k = finished();
  if (k <= streamed_ || recording_) co_return;
  streamed_ = k;
  compute(grid_start_ + k * conversion() - conversion() / 2, k);
  tell();
  co_await answer(reading_ + std::string(kWords));
}

// Sweeps all frequencies, deaf to commands meanwhile. Does not change whether the correction is
// applied, which is another setting.
Task<> Lcr6100Sim::correct() {
  co_await answer("Correction running");
  co_await clock_.wait_for(kSweepTime);
  const std::string verdict = faults_.correction_fails ? "fail" : "pass";
  co_await answer(verdict);
  restart_grid();
}

}  // namespace lcrig::lcr6100
