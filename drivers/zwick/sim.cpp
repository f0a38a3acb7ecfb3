// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/sim.hpp"

#include <algorithm>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <cmath>

#include "drivers/zwick/sim_machine.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
using frame_link::Line;
using frame_link::Refusal;
using frame_link::SimMachine;
using frame_link::Verdict;

constexpr Duration kIoTime = std::chrono::seconds(1);

Refusal syntax(const Error& error) {
  return Refusal("syntax", error.what);
}

Verdict set_limits(SimMachine& m, MonoTime t, const Line& line) {
  const auto limits = frame_link::parse_limits(line);
  if (!limits) return syntax(limits.error());
  return m.set_limits(t, *limits);
}

Verdict move(SimMachine& m, MonoTime t, const Line& line) {
  const auto travel = frame_link::length_of(line, "travel_mm");
  const auto speed = frame_link::speed_of(line);
  if (!travel) return syntax(travel.error());
  if (!speed) return syntax(speed.error());
  return m.move(t, *line.number, travel->si(), speed->si());
}

Verdict move_until(SimMachine& m, MonoTime t, const Line& line) {
  const auto force = frame_link::force_of(line);
  const auto speed = frame_link::speed_of(line);
  const auto guard = frame_link::length_of(line, "guard_mm");
  if (!force) return syntax(force.error());
  if (!speed) return syntax(speed.error());
  if (!guard) return syntax(guard.error());
  return m.move_until(t, *line.number, force->si(), speed->si(), guard->si());
}

Verdict ramp(SimMachine& m, MonoTime t, const Line& line) {
  const auto force = frame_link::force_of(line);
  const auto rate = line.number_of("rate_N_s");
  if (!force) return syntax(force.error());
  if (!rate) return syntax(rate.error());
  return m.ramp(t, *line.number, force->si(), *rate);
}

Verdict hold(SimMachine& m, MonoTime t, const Line& line) {
  const auto mode = line.text("mode");
  if (mode == "travel") {
    m.halt(t, MotionEnd::stopped, "hold");
    return std::nullopt;
  }
  if (mode != "force") return Refusal("syntax", "HOLD takes mode=travel or mode=force");
  const auto force = frame_link::force_of(line);
  if (!force) return syntax(force.error());
  return m.hold_force(t, force->si());
}

Verdict zero(SimMachine& m, MonoTime t, const Line& line) {
  return m.zero(t, line.flag("force"), line.flag("travel"));
}

using Handler = Verdict (*)(SimMachine&, MonoTime, const Line&);
constexpr std::array<std::pair<std::string_view, Handler>, 6> kHandlers{{
    {"LIMITS", set_limits},
    {"MOVE", move},
    {"MOVEF", move_until},
    {"RAMPF", ramp},
    {"HOLD", hold},
    {"ZERO", zero},
}};

}  // namespace

ZwickSim::ZwickSim(std::unique_ptr<Transport> transport, Clock& clock,
                   asio::any_io_executor executor, FrameScene& scene, ZwickSimSettings settings)
    : transport_(std::move(transport)),
      clock_(clock),
      settings_(std::move(settings)),
      machine_(std::make_unique<SimMachine>(scene, settings_)),
      wakeup_(std::move(executor)),
      power_on_(clock.now()) {}

ZwickSim::ZwickSim(std::unique_ptr<Transport> transport, Clock& clock,
                   asio::any_io_executor executor, std::vector<RecordedRow> rows,
                   ZwickSimSettings settings)
    : transport_(std::move(transport)),
      clock_(clock),
      settings_(std::move(settings)),
      recording_(std::move(rows)),
      wakeup_(std::move(executor)),
      power_on_(clock.now()) {}

ZwickSim::~ZwickSim() = default;

Task<> ZwickSim::run() {
  co_await (read() || serve());
  closed_ = true;
  transport_->close();
  if (machine_) machine_->halt(clock_.now(), MotionEnd::fault, "link closed");
}

void ZwickSim::close() {
  closed_ = true;
  transport_->close();
  wakeup_.notify();
}

void ZwickSim::attach(std::unique_ptr<Transport> transport) {
  transport_ = std::move(transport);
  closed_ = session_ = false;
  splitter_ = frame_link::LineSplitter();
  out_.clear();
}

void ZwickSim::start_recording() {
  if (!recording_start_) recording_start_ = clock_.now();
  wakeup_.notify();
}

void ZwickSim::stall() {
  if (machine_) machine_->stall(clock_.now());
}
bool ZwickSim::is_moving() const {
  return machine_ && machine_->is_moving();
}
bool ZwickSim::is_armed() const {
  return machine_ && machine_->is_armed();
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
    say(std::exchange(faults.say, {}));
    if (!out_.empty()) {
      const std::string bytes = std::exchange(out_, {});
      said_ = now;
      auto written = co_await transport_->write_all(bytes, now + kIoTime);
      if (!written) co_return;
      continue;
    }
    const MonoTime due = next_due();
    if (due == MonoTime::max()) {
      co_await wakeup_.wait();
    } else {
      co_await wakeup_.wait_until(clock_, due);
    }
  }
}

MonoTime ZwickSim::next_due() const {
  if (!session_) return MonoTime::max();
  MonoTime due = std::max(clock_.now(), said_ + frame_link::kHeartbeat);
  if (faults.silent) due = clock_.now() + frame_link::kHeartbeat;
  if (!watchdog_tripped_) due = std::min(due, heard_ + frame_link::kSilence);
  if (const auto event = machine_ ? machine_->next_event() : std::nullopt) {
    due = std::min(due, *event);
  }
  if (rate_Hz_ > 0 && machine_) {
    // The last sample of this batch: the device fills a batch, then sends it.
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
    return *recording_start_ + from_seconds(rows[next_row_].t_s - rows.front().t_s);
  }
  if (rate_Hz_ <= 0) return std::nullopt;
  return sample_time(rate_index_);
}

// Samples and machine events up to now, in the order of their own times.
void ZwickSim::catch_up(MonoTime now) {
  if (machine_) machine_->set_never_complete(faults.never_complete);
  for (;;) {
    const auto event = machine_ ? machine_->next_event() : std::nullopt;
    const auto due = next_sample();
    if (event && *event <= now && (!due || *event <= *due)) {
      machine_->advance();
      finish_motion();
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
  if (stop_owed_ && !is_moving()) answer_stops();
}

double ZwickSim::device_time_s(MonoTime t) const {
  const double elapsed = to_seconds(t - power_on_) * (1 + settings_.device_clock_ppm * 1e-6);
  const double exact = settings_.device_clock_start_s + elapsed + faults.clock_jump_s;
  return std::round(exact * 1e6) / 1e6;  // the device counts microseconds
}

void ZwickSim::take_sample(MonoTime t) {
  FrameSample s = machine_->sample(t);
  s.device_time_s = device_time_s(t);
  ++rate_index_;
  s.device_seq = seq_++;
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
  if (!faults.silent) frame_link::append_samples(out_, batch_);
  batch_.clear();
}

void ZwickSim::say(std::string_view line) {
  if (!faults.silent) out_ += line;
}

void ZwickSim::finish_motion() {
  const auto finished = machine_->take_finished();
  if (!finished || !finished->number || !session_) return;
  flush();
  if (faults.lose_done > 0) {
    --faults.lose_done;
    return;
  }
  say(frame_link::format_done(*finished->number, finished->outcome));
}

void ZwickSim::supervise(MonoTime now) {
  if (!session_) return;
  if (!watchdog_tripped_ && now - heard_ >= frame_link::kSilence) {
    watchdog_tripped_ = true;
    if (machine_) {
      machine_->halt(now, MotionEnd::fault, "host silent");
      machine_->disarm();
    }
    say(frame_link::format_event("watchdog", "host silent for 1 s"));
    catch_up(now);
  }
  if (out_.empty() && now - said_ >= frame_link::kHeartbeat) {
    say(frame_link::format_heartbeat(device_time_s(now)));
  }
}

void ZwickSim::open_session() {
  const MonoTime now = clock_.now();
  if (machine_) {
    machine_->halt(now, MotionEnd::stopped, "new session");
    machine_->disarm();
  }
  session_ = true;
  watchdog_tripped_ = false;
  batch_.clear();
  out_.clear();
  rate_Hz_ = 0;
  seq_ = 1;
  stops_ = 0;
  stop_owed_ = false;
  frame_link::Hello hello;
  hello.side = "gateway";
  hello.identity.maker = "lcrig";
  hello.identity.model = recording_ ? "frame recording" : "simulated frame";
  hello.identity.serial = settings_.serial;
  hello.identity.firmware = LCRIG_VERSION;
  say(frame_link::format_hello(hello));
  FrameCapabilities caps;
  if (machine_) {
    caps = machine_->capabilities();
  } else {
    caps.sample_rate_max_Hz = settings_.rate_max_Hz;
    caps.deceleration = 0.05_m_s2;
  }
  say(frame_link::format_caps(caps));
}

void ZwickSim::on_line(std::string_view text) {
  if (text.empty()) return;
  const MonoTime now = clock_.now();
  catch_up(now);
  const auto line = frame_link::parse_line(text);
  if (!line) {
    say(frame_link::format_event("syntax", line.error().what));
    return;
  }
  heard_ = now;
  watchdog_tripped_ = false;
  if (line->word == "STOP") return on_stop();
  if (line->word == "HELLO") return open_session();
  if (line->word == "HB" || !session_) return;
  if (line->number) return on_command(*line);
  say(frame_link::format_event("unknown", line->word));
}

void ZwickSim::on_stop() {
  ++stops_;
  stop_owed_ = true;
  if (machine_) machine_->halt(clock_.now(), MotionEnd::stopped, "STOP");
  catch_up(clock_.now());
}

void ZwickSim::answer_stops() {
  stop_owed_ = false;
  flush();
  if (faults.lose_stopped > 0) {
    --faults.lose_stopped;
    return;
  }
  MotionOutcome standing;
  if (machine_) {
    const FrameSample s = machine_->sample(clock_.now());
    standing.force_N = s.force_N;
    standing.travel_m = s.travel_m;
  }
  say(frame_link::format_stopped(stops_, standing));
}

void ZwickSim::on_command(const Line& line) {
  Verdict no = Refusal("unknown_command", "no such command");
  const auto handler =
      std::ranges::find(kHandlers, line.word, [](const auto& h) { return h.first; });
  if (!faults.refuse_next.empty()) {
    no = Refusal(std::exchange(faults.refuse_next, {}), "not now");
  } else if (line.word == "STATUS") {
    no.reset();
  } else if (line.word == "RATE") {
    return set_rate(line);
  } else if (handler != kHandlers.end() && !machine_) {
    no = Refusal("unsupported", "a recording is played: nothing moves");
  } else if (handler != kHandlers.end()) {
    no = handler->second(*machine_, clock_.now(), line);
  }
  if (faults.lose_answers > 0) {
    --faults.lose_answers;
  } else if (no) {
    say(frame_link::format_err(*line.number, no->code, no->text));
  } else {
    say(frame_link::format_ok(*line.number));
  }
  catch_up(clock_.now());
}

void ZwickSim::set_rate(const Line& line) {
  const auto hz = line.number_of("hz");
  if (!hz) return say(frame_link::format_err(*line.number, "syntax", hz.error().what));
  if (*hz < 0) return say(frame_link::format_err(*line.number, "bad_value", "a negative rate"));
  if (*hz > settings_.rate_max_Hz) {
    return say(frame_link::format_err(*line.number, "machine_limits", "faster than rate_max_hz"));
  }
  flush();
  rate_Hz_ = *hz;
  rate_start_ = clock_.now();
  rate_index_ = 1;
  say(frame_link::format_ok(*line.number));
}

}  // namespace lcrig
