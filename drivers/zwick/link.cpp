// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/link.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/this_coro.hpp>
#include <cmath>

#include "base/text.hpp"

namespace lcrig::frame_link {

namespace {

constexpr Duration kWriteTime = std::chrono::seconds(1);
constexpr Duration kGarbageReports = std::chrono::seconds(1);  // at most one event in this time
constexpr double kClockTolerance_s = 0.5;  // a late batch is late by less than kSilence

// `busy` and `not_ready` have codes of their own; every other word means that the machine refused.
Errc errc_of(std::string_view code) {
  if (code == "busy") return Errc::busy;
  return code == "not_ready" ? Errc::frame_fault : Errc::refused;
}

Hello our_hello() {
  Hello hello;
  hello.side = "host";
  hello.identity.maker = "lcrig";
  hello.identity.model = "lcrigd";
  hello.identity.firmware = LCRIG_VERSION;
  return hello;
}

}  // namespace

Link::Link(std::unique_ptr<Transport> transport, Clock& clock, asio::any_io_executor executor)
    : transport_(std::move(transport)), clock_(clock), executor_(std::move(executor)) {}

Link::Waiting::Waiting(std::shared_ptr<Link> link) : link_(std::move(link)) {
  link_->waiting_.push_back(&wakeup_);
}
Link::Waiting::~Waiting() {
  std::erase(link_->waiting_, &wakeup_);
}

Task<Result<>> Link::Waiting::next(std::optional<MonoTime> deadline) {
  if (link_->lost_) co_return fail(*link_->lost_);
  co_await link_->clock_.wait_until(deadline.value_or(MonoTime::max()), wakeup_);
  const auto state = co_await asio::this_coro::cancellation_state;
  if (state.cancelled() != asio::cancellation_type::none) {
    co_return fail(Errc::aborted, "{}: the wait was given up", link_->name());
  }
  co_return Result<>();
}

Link::Exchange::Exchange(std::shared_ptr<Link> link)
    : number(++link->last_number_), stops(link->stops_sent_), waiting(link) {
  link->exchanges_.emplace(number, this);
}
Link::Exchange::~Exchange() {
  waiting.link().exchanges_.erase(number);
}

void Link::start() {
  if (started_ || lost_) return;
  started_ = true;
  heard_ = sent_ = clock_.now();
  const auto on_end = [self = shared_from_this()](std::exception_ptr error) {
    if (!error) return;
    self->lose(Error(Errc::bug, self->name() + ": an exception escaped from the frame link"));
  };
  asio::co_spawn(executor_, [self = shared_from_this()] { return self->read(); }, on_end);
  asio::co_spawn(executor_, [self = shared_from_this()] { return self->write(); }, on_end);
}

void Link::end(Error error) {
  if (!lost_) lost_ = std::move(error);
  transport_->close();
  writer_.notify();
  knock();
}

void Link::lose(Error error) {
  if (lost_) return;
  end(error);
  if (listener_ != nullptr) listener_->on_frame_lost(std::move(error));
}

void Link::queue(std::string_view line) {
  queue_ += line;
  writer_.notify();
}

void Link::send_hello() {
  observer_ = false;
  send_stop();
  greet(format_hello(our_hello()));
}

void Link::send_observe(double rate_Hz) {
  observer_ = true;
  greet(format_observe(our_hello(), rate_Hz));
}

void Link::greet(std::string_view line) {
  ++hellos_owed_;
  caps_owed_ = true;
  stops_sent_ = stopped_ = 0;
  // The LF ends a line that a previous daemon may have left unfinished in the gateway's buffer.
  queue("\n");
  queue(line);
}

void Link::give_up_greeting() {
  hellos_owed_ = 0;
  caps_owed_ = false;
}

std::int64_t Link::send_stop() {
  // The LF ends a line that a previous daemon may have left unfinished. Otherwise the gateway would
  // read STOP as part of it.
  if (!identity_) urgent_ += "\n";
  urgent_ += kStop;
  writer_.notify();
  return ++stops_sent_;
}

void Link::event(EventName kind, std::string detail) {
  if (listener_ != nullptr) listener_->on_frame_event(std::move(kind), std::move(detail));
}

Task<> Link::write() {
  while (!lost_) {
    const MonoTime due = sent_ + kHeartbeat;
    if (urgent_.empty() && queue_.empty() && clock_.now() < due) {
      co_await clock_.wait_until(due, writer_);
      continue;
    }
    std::string bytes = std::exchange(urgent_, {});
    bytes += std::exchange(queue_, {});
    sent_ = clock_.now();
    if (bytes.empty() && is_greeted()) bytes = kHostHeartbeat;
    if (bytes.empty()) continue;
    auto written = co_await transport_->write_all(bytes, sent_ + kWriteTime);
    if (!written) lose(written.error());
  }
}

Task<> Link::read() {
  while (!lost_) {
    auto n = co_await transport_->read_some(buffer_, heard_ + kSilence);
    if (lost_) co_return;
    if (n) {
      splitter_.feed(std::string_view(buffer_.data(), *n));
      while (const auto text = splitter_.next()) dispatch(*text);
      const auto dropped = splitter_.dropped();
      if (std::exchange(dropped_, dropped) != dropped) on_garbage("", "a line beyond 64 kB");
    } else if (n.error().code != Errc::no_reply) {
      lose(n.error());
    } else if (is_greeted()) {
      lose(Error(Errc::disconnected, name() + ": the gateway was silent for 1 s"));
    } else {
      heard_ = clock_.now();
    }
    // Garbage makes read_some return, but does not prove that the gateway is alive.
    if (!lost_ && is_greeted() && clock_.now() - heard_ >= kSilence) {
      lose(Error(Errc::disconnected, name() + ": no valid line from the gateway for 1 s"));
    }
  }
}

void Link::dispatch(std::string_view text) {
  if (lost_ || text.empty()) return;
  auto line = parse_line(text);
  if (!line) return on_garbage(text, line.error().what);
  if (line->word == "HELLO") return on_hello(*line);
  if (line->word == "STOPPED") return on_stopped(*line);
  if (!identity_) return on_garbage(text, "before HELLO");  // from an older session
  heard_ = clock_.now();
  if (line->word == "S") return on_samples(*line);
  if (line->word == "HB") return;
  if (line->word == "CAPS") return on_caps(*line);
  dispatch_report(*line);
}

void Link::dispatch_report(const Line& line) {
  if (line.word == "EVENT") return on_event(line);
  const bool is_answer = line.word == "OK" || line.word == "ERR";
  if (!is_answer && line.word != "DONE") return on_garbage(line.word, "unknown message");
  if (!line.number) return on_garbage(line.word, "an answer without a number");
  if (is_answer) {
    on_answer(line);
  } else {
    on_done(line);
  }
  knock();
}

void Link::on_hello(const Line& line) {
  auto hello = parse_hello(line);
  if (!hello) return on_garbage("HELLO", hello.error().what);
  if (hellos_owed_ == 0) {
    if (!identity_) return;  // from an older session: ours has not asked yet
    return lose(Error(Errc::disconnected, name() + ": the gateway was restarted"));
  }
  --hellos_owed_;
  heard_ = clock_.now();
  identity_ = *hello;
  origin_.reset();
  if (hello->revision >= 2) take_origin(line);
  next_seq_.reset();
  device_time_s_.reset();
  knock();
}

void Link::on_caps(const Line& line) {
  auto caps = parse_caps(line);
  if (!caps) return on_garbage("CAPS", caps.error().what);
  caps_ = *caps;
  if (hellos_owed_ == 0) caps_owed_ = false;
  knock();
}

void Link::take_origin(const Line& line) {
  if (line.find("origin")) origin_ = printable(line.text("origin"));
}

void Link::on_event(const Line& line) {
  EventName kind("device_" + printable(line.text("kind")));  // printable, because a database
                                                             // accepts UTF-8 only
  if (kind == EventKind::device_origin) take_origin(line);
  event(std::move(kind), line.text("text"));
}

void Link::on_answer(const Line& line) {
  const auto it = exchanges_.find(*line.number);
  if (it == exchanges_.end() || it->second->answer) {
    return event(EventKind::late_answer, fmt::format("{} #{}", line.word, *line.number));
  }
  if (line.word == "OK") {
    take_origin(line);
    it->second->answer = Result<>();
    return;
  }
  const auto code = line.text("code");
  // If a STOP overtook the command, the refusal is not a fault of the machine.
  const bool overtaken = stops_sent_ > it->second->stops;
  it->second->answer = fail(overtaken ? Errc::refused : errc_of(code), "{}: refused: {} ({})",
                            name(), printable(line.text("text")), printable(code));
}

void Link::on_done(const Line& line) {
  MotionOutcome outcome = parse_done(line);
  // Reported even for a stopped motion, because a fault during braking is a fault. Not reported for
  // an unknown reason or a DONE of another session.
  const bool ours = *line.number <= last_number_;
  if (ours && line.text("reason") == to_string(MotionEnd::fault) && outcome.detail != kHostSilent) {
    event(EventKind::motion_fault, outcome.detail);
  }
  const auto it = exchanges_.find(*line.number);
  if (it == exchanges_.end()) return;  // its task was cancelled; samples show the end
  if (!it->second->answer) it->second->answer = Result<>();
  it->second->done = std::move(outcome);
}

void Link::on_stopped(const Line& line) {
  heard_ = clock_.now();
  // Until HELLO is answered, the number belongs to the previous session.
  if (!identity_ || hellos_owed_ > 0) {
    stopped_ = stops_sent_;
    return knock();
  }
  const auto stops = line.number_of("stops");
  if (!stops) return on_garbage("STOPPED", stops.error().what);
  // A STOP that was not sent cannot be confirmed.
  const bool possible = *stops >= 0 && *stops <= static_cast<double>(stops_sent_);
  if (!possible) return on_garbage("STOPPED", "a count of STOPs that were not sent");
  stopped_ = std::max(stopped_, static_cast<std::int64_t>(*stops));
  knock();
}

void Link::on_samples(const Line& line) {
  batch_.clear();
  const auto parsed = parse_samples(line, batch_);
  if (!parsed) return on_garbage("S", parsed.error().what);
  for (auto& s : batch_) s.received = clock_.now();
  check_sequence();
  if (batch_.empty()) return;
  check_device_clock();
  if (listener_ != nullptr) listener_->on_samples(batch_);
}

void Link::check_sequence() {
  const auto first = batch_.front().device_seq;
  const auto expected = next_seq_.value_or(first);
  if (first > expected) {
    batch_.front().flags |= frame_flag::kAfterGap;
    event(EventKind::gap,
          fmt::format("{}: {} samples missing before seq {}", name(), first - expected, first));
  } else if (first < expected) {
    // Samples are never passed on twice, because (run, seq) is a key of the recording.
    const auto n = std::erase_if(batch_, [&](const auto& s) { return s.device_seq < expected; });
    event(EventKind::repeated_samples,
          fmt::format("{}: {} samples from seq {} again", name(), n, first));
  }
  if (!batch_.empty()) next_seq_ = batch_.back().device_seq + 1;
}

void Link::check_device_clock() {
  const auto& last = batch_.back();
  if (!last.device_time_s) return;
  if (device_time_s_) {
    const double device_s = *last.device_time_s - *device_time_s_;
    const double host_s = to_seconds(last.received - device_time_received_);
    if (device_s < 0 || std::abs(device_s - host_s) > kClockTolerance_s) {
      event(EventKind::device_clock_jump,
            fmt::format("{}: device clock went {:.3f} s in {:.3f} s", name(), device_s, host_s));
    }
  }
  device_time_s_ = last.device_time_s;
  device_time_received_ = last.received;
}

void Link::on_garbage(std::string_view text, std::string_view why) {
  garbage_ = printable(text.substr(0, 60));
  garbage_why_ = printable(why.substr(0, 200));
  ++garbage_count_;
  knock();
  const bool first = garbage_reported_ == MonoTime();
  if (!is_greeted() || (!first && clock_.now() < garbage_reported_ + kGarbageReports)) return;
  garbage_reported_ = clock_.now();
  event(EventKind::garbled,
        fmt::format("{}: {} lines, last '{}': {}", name(), garbage_count_, garbage_, garbage_why_));
  garbage_count_ = 0;
}

}  // namespace lcrig::frame_link
