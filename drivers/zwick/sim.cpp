// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/sim.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/clock.hpp"
#include "base/either.hpp"
#include "drivers/zwick/sim_clerk.hpp"
#include "drivers/zwick/sim_machine.hpp"

namespace lcrig {

namespace {

using frame_link::SimClerk;
using frame_link::SimMachine;

constexpr Duration kIoTime = std::chrono::seconds(1);

}  // namespace

ZwickSim::ZwickSim(std::unique_ptr<Transport> transport, Clock& clock, FrameScene& scene,
                   ZwickSimSettings settings)
    : transport_(std::move(transport)),
      clock_(clock),
      settings_(std::move(settings)),
      machine_(std::make_unique<SimMachine>(scene, settings_)),
      clerk_(std::make_unique<SimClerk>(*machine_)),
      noise_(settings_.seed),
      random_(settings_.seed + 1),
      power_on_(clock.now()) {}

ZwickSim::ZwickSim(std::unique_ptr<Transport> transport, Clock& clock,
                   std::vector<RecordedRow> rows, ZwickSimSettings settings)
    : transport_(std::move(transport)),
      clock_(clock),
      settings_(std::move(settings)),
      recording_(std::move(rows)),
      noise_(settings_.seed),
      random_(settings_.seed + 1),
      power_on_(clock.now()) {}

ZwickSim::~ZwickSim() = default;

Task<> ZwickSim::run() {
  co_await either(read(), serve());
  closed_ = true;
  transport_->close();
  if (!observer_) end_command("link closed");
}

// Called when the commanding host is gone. The machine stops and must be armed again.
void ZwickSim::end_command(std::string_view why) {
  if (!machine_) return;
  clerk_->end_session();
  machine_->halt(clock_.now(), MotionEnd::fault, std::string(why));
  machine_->disarm();
}

void ZwickSim::close() {
  closed_ = true;
  transport_->close();
  wakeup_.notify();
}

void ZwickSim::attach(std::unique_ptr<Transport> transport) {
  transport_ = std::move(transport);
  closed_ = session_ = observer_ = false;
  splitter_ = frame_link::LineSplitter();
  out_.clear();
  line_.clear();
  answers_.clear();
}

void ZwickSim::start_recording() {
  if (!recording_start_) recording_start_ = clock_.now();
  wakeup_.notify();
}

void ZwickSim::stall() {
  if (machine_) machine_->stall(clock_.now());
}

void ZwickSim::trip(std::string_view kind, std::string_view text) {
  if (machine_) machine_->halt(clock_.now(), MotionEnd::fault, std::string(text));
  if (!kind.empty()) say(frame_link::format_event(kind, text));
  wakeup_.notify();
}

void ZwickSim::forget() {
  if (machine_) machine_->forget();
  power_on_ = clock_.now();
}

void ZwickSim::restart() {
  if (machine_) {
    clerk_->end_session();
    machine_->halt(clock_.now(), MotionEnd::fault, "gateway restarted");
    machine_->disarm();
  }
  session_ = false;
  batch_.clear();
  out_.clear();
  answers_.clear();
  say(hello());
  wakeup_.notify();
}

bool ZwickSim::is_moving() const {
  return machine_ && machine_->is_moving();
}
bool ZwickSim::is_armed() const {
  return machine_ && machine_->is_armed();
}
double ZwickSim::travel_zero_m() const {
  return machine_ ? machine_->travel_zero_m() : 0;
}

Task<> ZwickSim::read() {
  while (!closed_) {
    auto n = co_await transport_->read_some(buffer_, clock_.now() + std::chrono::hours(1));
    if (!n && n.error().code != Errc::no_reply) co_return;
    if (!n || faults.deaf) continue;
    splitter_.feed(std::string_view(buffer_.data(), *n));
    while (const auto text = splitter_.next()) on_line(*text);
    wakeup_.notify();
  }
}

Task<> ZwickSim::serve() {
  while (!closed_) {
    const MonoTime now = clock_.now();
    catch_up(now);
    supervise(now);
    release_answers(now);
    say(std::exchange(faults.say, {}));
    if (!out_.empty()) transmit(std::exchange(out_, {}), now);
    if (!line_.empty() && line_.front().due <= now) {
      const std::string bytes = std::move(line_.front().bytes);
      line_.pop_front();
      auto written = co_await transport_->write_all(bytes, now + kIoTime);
      if (!written) co_return;
      continue;
    }
    co_await clock_.wait_until(next_due(), wakeup_);
  }
}

// Sends one transmission, with the faults of the line.
void ZwickSim::transmit(std::string bytes, MonoTime now) {
  said_ = now;
  const LineFault fault = hooks.sends ? hooks.sends() : LineFault();
  bytes = spoiled(std::move(bytes), fault.kind);
  noise_.spoil(bytes, faults.byte_noise);
  MonoTime due = now + fault.delay + from_seconds(settings_.line_delay_s);
  if (settings_.line_jitter_s > 0) due += from_seconds(settings_.line_jitter_s * chance());
  if (!line_.empty()) due = std::max(due, line_.back().due);
  if (!bytes.empty()) line_.emplace_back(due, std::move(bytes));
}

MonoTime ZwickSim::next_due() const {
  MonoTime sent = line_.empty() ? MonoTime::max() : line_.front().due;
  if (!answers_.empty()) sent = std::min(sent, answers_.front().due);
  if (!session_) return sent;
  MonoTime due = std::max(clock_.now(), said_ + frame_link::kHeartbeat);
  if (faults.silent || silenced_ || faults.no_heartbeats)
    due = clock_.now() + frame_link::kHeartbeat;
  due = std::min(due, sent);
  if (!watchdog_tripped_) due = std::min(due, heard_ + frame_link::kSilence);
  if (const auto event = clerk_ ? clerk_->next_event() : std::nullopt) due = std::min(due, *event);
  if (stop_due_) due = std::min(due, *stop_due_);
  if (rate_Hz_ > 0 && machine_) {
    // The device fills a batch before it sends it, so wake at the batch's last sample.
    const auto missing = static_cast<std::int64_t>(0.1 * rate_Hz_) - std::ssize(batch_) - 1;
    due = std::min(due, sample_time(rate_index_ + std::max<std::int64_t>(0, missing)));
  } else if (const auto row = next_sample()) {
    due = std::min(due, *row);
  }
  return due;
}

MonoTime ZwickSim::sample_time(std::int64_t k) const {
  return rate_start_ + from_seconds(static_cast<double>(k) / rate_Hz_);
}

std::optional<MonoTime> ZwickSim::next_sample() const {
  if (!session_) return std::nullopt;
  if (recording_) {
    if (!recording_start_ || next_row_ >= recording_->size()) return std::nullopt;
    const auto& rows = *recording_;
    return *recording_start_ + from_seconds(rows[next_row_].t_s);
  }
  if (rate_Hz_ <= 0) return std::nullopt;
  return sample_time(rate_index_);
}

// Takes samples and handles machine events up to now, in the order of their times.
void ZwickSim::catch_up(MonoTime now) {
  if (machine_) machine_->set_never_complete(faults.never_complete);
  if (machine_) machine_->set_late_stop(faults.late_stop_s);
  play_until(now);
  lie(now);
  play_until(now);
  owe_stops(now);
}

void ZwickSim::play_until(MonoTime now) {
  finish_motions();
  for (;;) {
    const auto event = clerk_ ? clerk_->next_event() : std::nullopt;
    const auto due = next_sample();
    if (event && *event <= now && (!due || *event <= *due)) {
      clerk_->advance();
      finish_motions();
    } else if (due && *due <= now) {
      if (recording_) {
        take_row(*due);
      } else {
        take_sample(*due);
      }
    } else {
      break;
    }
  }
}

// Applies lies that were changed from outside.
void ZwickSim::lie(MonoTime now) {
  if (!machine_) return;
  if (std::exchange(faults.lose_tare, false)) {
    const bool tells = std::exchange(faults.tell_origin, false) && settings_.revision >= 2;
    machine_->lose_tare(tells);
    if (tells && session_) {
      say(fmt::format("EVENT kind=\"origin\" origin=\"{}\" text=\"the tare was lost\"\n",
                      machine_->origin()));
    }
  }
  if (faults.lies == lies_) return;
  clock_gain_s_ += to_seconds(now - clock_since_) * (lies_.clock_rate - 1);
  clock_since_ = now;
  const bool pulled = faults.lies.estop && !lies_.estop;
  lies_ = faults.lies;
  silenced_ = silenced_ && lies_.stop_silences;
  machine_->set_lies(now, lies_);
  clerk_->set_lies(now, lies_);
  if (pulled && session_) say(frame_link::format_event("estop", "E-stop"));
}

void ZwickSim::owe_stops(MonoTime now) {
  if (!stop_owed_) return;
  if (!stop_due_ && is_moving()) return;
  if (!stop_due_) stop_due_ = now + from_seconds(lies_.stop_late_s);
  if (*stop_due_ <= now) answer_stops();
}

double ZwickSim::device_time_s(MonoTime t) const {
  const double elapsed = to_seconds(t - power_on_) * (1 + settings_.device_clock_ppm * 1e-6);
  const double gained = clock_gain_s_ + to_seconds(t - clock_since_) * (lies_.clock_rate - 1);
  const double exact = settings_.device_clock_start_s + elapsed + gained + faults.clock_jump_s;
  return std::round(exact * 1e6) / 1e6;  // the device counts microseconds
}

void ZwickSim::take_sample(MonoTime t) {
  const bool spike = faults.spike_samples > 0;
  if (spike) --faults.spike_samples;
  FrameSample s = machine_->sample(t, spike ? faults.spike_N : 0);
  if (spike) machine_->feel(t, s);
  s.device_time_s = device_time_s(t);
  ++rate_index_;
  s.device_seq = seq_++;
  const auto missing = [this](double share) { return share > 0 && chance() < share; };
  if (missing(settings_.missing_time)) s.device_time_s.reset();
  if (missing(settings_.missing_force)) s.force_N.reset();
  if (missing(settings_.missing_travel)) s.travel_m.reset();
  if (watch) watch(t, s);
  if (faults.lose_samples > 0) {
    --faults.lose_samples;
    return flush();
  }
  batch_.push_back(s);
  finish_batch();
}

void ZwickSim::take_row(MonoTime) {
  const RecordedRow& row = (*recording_)[next_row_++];
  FrameSample s;
  s.device_time_s = row.t_s + faults.clock_jump_s;
  s.travel_m = row.travel_m;
  s.force_N = row.force_N;
  s.device_seq = seq_++;
  batch_.push_back(s);
  flush();
  if (next_row_ == recording_->size()) {
    say(frame_link::format_event("recording_end", "all rows were played"));
  }
}

void ZwickSim::finish_batch() {
  if (static_cast<double>(batch_.size() + 1) > 0.1 * rate_Hz_) flush();
}

void ZwickSim::flush() {
  if (batch_.empty()) return;
  if (!faults.silent && !silenced_) frame_link::append_samples(out_, batch_);
  batch_.clear();
}

void ZwickSim::say(std::string_view line) {
  if (!faults.silent && !silenced_) out_ += line;
}

double ZwickSim::chance() {
  return static_cast<double>(random_() >> 11U) * 0x1p-53;
}

// Answers stay in order, so that the end of a motion never overtakes the answer to its command.
void ZwickSim::answer(std::string line) {
  MonoTime due = clock_.now();
  if (settings_.answer_delay_s > 0) due += from_seconds(settings_.answer_delay_s * chance());
  if (!answers_.empty()) due = std::max(due, answers_.back().due);
  if (due <= clock_.now()) return say(line);
  answers_.emplace_back(due, std::move(line));
}

void ZwickSim::release_answers(MonoTime until) {
  while (!answers_.empty() && answers_.front().due <= until) {
    say(answers_.front().bytes);
    answers_.pop_front();
  }
}

void ZwickSim::finish_motions() {
  while (const auto finished = clerk_ ? clerk_->take_finished() : std::nullopt) {
    if (!finished->number || !session_) continue;
    flush();
    if (faults.lose_done > 0) {
      --faults.lose_done;
      continue;
    }
    if (hooks.loses_done && hooks.loses_done()) continue;
    std::string done = frame_link::format_done(*finished->number, finished->outcome);
    if (answers_.empty()) {
      say(done);
    } else {
      answers_.emplace_back(answers_.back().due, std::move(done));
    }
  }
}

void ZwickSim::supervise(MonoTime now) {
  if (!session_) return;
  if (!watchdog_tripped_ && now - heard_ >= frame_link::kSilence) {
    watchdog_tripped_ = true;
    if (observer_) {
      session_ = false;
      return;
    }
    if (machine_) {
      machine_->halt(now, MotionEnd::fault, std::string(frame_link::kHostSilent));
      machine_->disarm();
    }
    say(frame_link::format_event("watchdog", "host silent for 1 s"));
    catch_up(now);
  }
  if (out_.empty() && !faults.no_heartbeats && now - said_ >= frame_link::kHeartbeat) {
    say(frame_link::format_heartbeat(device_time_s(now)));
  }
}

}  // namespace lcrig
