// SPDX-License-Identifier: Apache-2.0
#include "drivers/lcr6100/driver.hpp"

#include <algorithm>
#include <utility>

#include "base/clock.hpp"
#include "base/text.hpp"

namespace lcrig::lcr6100 {

namespace {

using namespace std::chrono_literals;

constexpr Duration kAfterOpen = 500ms;  // needed by the meter's USB bridge
constexpr Duration kPace = 150ms;  // after a set command; without it some are lost
constexpr Duration kReplyTime = 1s;
constexpr Duration kCorrectionTime = 120s;
constexpr int kTries = 3;
constexpr int kSlowReadings = 5;
// FAST at 1 kHz and above gives 15 readings a second. A much lower rate means that the meter fell
// into its slow state. Sending the set-up again ends that state.
constexpr double kFastFrom = 1000;  // Hz
constexpr double kSlowFactor = 2.2;

bool is_fatal(Errc code) {
  return code != Errc::no_reply && code != Errc::reply_cut_off && code != Errc::garbled;
}

}  // namespace

Lcr6100::Lcr6100(std::unique_ptr<Transport> transport, Clock& clock, std::string expected_serial)
    : link_(std::move(transport), clock),
      clock_(clock),
      expected_serial_(std::move(expected_serial)),
      capabilities_(lcr6100::capabilities()),
      opened_(clock.now()) {}

Task<> Lcr6100::wake() {
  if (awake_) co_return;
  if (clock_.now() < opened_ + kAfterOpen) co_await clock_.wait_until(opened_ + kAfterOpen);
  awake_ = true;
}

Task<Result<>> Lcr6100::set(std::string_view command) {
  auto sent = co_await link_.send(command);
  if (sent) co_await clock_.wait_for(kPace);
  co_return sent;
}

// The first line after opening may be garbage, and the instrument is not known yet. Therefore this
// asks up to three times, and empties the line before each.
Task<Result<Reply>> Lcr6100::ask_identity() {
  Result<Reply> reply = fail(Errc::no_reply, "{}: not asked", link_.name());
  for (int i = 0; i < kTries; ++i) {
    auto flushed = co_await link_.flush();
    if (!flushed) co_return fail(flushed.error());
    reply = co_await link_.query("*IDN?", kReplyTime);
    if (reply && parse_identity(reply->text)) {
      link_.set_identity(reply->text);
      if (i == 0) co_return reply;
      auto clean = co_await link_.resync();
      if (!clean) co_return fail(clean.error());
      co_return reply;
    }
    if (!reply && is_fatal(reply.error().code)) break;
  }
  co_return reply;
}

Task<Result<Identity>> Lcr6100::identify() {
  co_await wake();
  auto reply = co_await ask_identity();
  if (link_.heard_no_text() && !(reply && parse_identity(reply->text))) {
    co_return fail(Errc::garbled, "{}: bytes came that are no answer to *IDN? ({}): {}",
                   link_.name(), printable(reply ? reply->text : reply.error().what), kLineWords);
  }
  if (!reply && reply.error().code == Errc::no_reply) {
    co_return fail(Errc::no_reply,
                   "{}; check power and cable, and that the meter's system menu has this port "
                   "chosen (RS-232 or USB: only one of them answers)",
                   reply.error().what);
  }
  if (!reply) co_return fail(reply.error());
  auto identity = parse_identity(reply->text);
  if (!identity || !is_supported_model(identity->model)) {
    co_return fail(Errc::refused, "{}: \"{}\" answered; expected a GW Instek LCR-6000 or LCR-76000",
                   link_.name(), printable(reply->text));
  }
  if (!expected_serial_.empty() && identity->serial != expected_serial_) {
    co_return fail(Errc::refused, "{}: the meter with serial number {} answered; expected {}",
                   link_.name(), printable(identity->serial), expected_serial_);
  }
  auto quiet = co_await quieten();
  if (!quiet) co_return fail(quiet.error());
  co_return identity;
}

// Turns result codes off. Turns echo and unrequested readings off if the meter sends them.
Task<Result<>> Lcr6100::quieten() {
  auto sent = co_await set("SYST:CODE OFF");
  if (!sent) co_return sent;
  auto probe = co_await link_.query("*IDN?", kReplyTime);
  if (!probe && is_fatal(probe.error().code)) co_return fail(probe.error());
  if (link_.take_echo_seen()) {
    sent = co_await set("SYST:SHAK OFF");
    if (!sent) co_return sent;
  }
  if (link_.take_stray_seen()) {
    sent = co_await set("SYST:RES FETCH");
    if (!sent) co_return sent;
  }
  co_return sent;
}

Result<> Lcr6100::check(const LcrSettings& s) const {
  const auto& c = capabilities_;
  const auto refuse = [this](std::string_view what, double value, double min, double max) {
    return fail(Errc::invalid_request, "{}: {} {} is out of range ({} to {})", link_.name(), what,
                value, min, max);
  };
  if (s.frequency < c.frequency_min || s.frequency > c.frequency_max) {
    return refuse("frequency_Hz", s.frequency.si(), c.frequency_min.si(), c.frequency_max.si());
  }
  if (s.level < c.level_min || s.level > c.level_max) {
    return refuse("level_V", s.level.si(), c.level_min.si(), c.level_max.si());
  }
  if (s.bias && (*s.bias < c.bias_min || *s.bias > c.bias_max)) {
    return refuse("bias_V", s.bias->si(), c.bias_min.si(), c.bias_max.si());
  }
  if (s.average < 1 || s.average > c.average_max) {
    return refuse("average", s.average, 1, c.average_max);
  }
  return {};
}

// Sends one setting until its read-back matches, up to three times.
Task<Result<>> Lcr6100::establish(const Setting& setting, LcrSettings& got) {
  Result<Reply> reply = fail(Errc::bug, "{}: not asked", link_.name());
  for (int i = 0; i < kTries; ++i) {
    if (must_settle(setting.id)) settled_ = clock_.now() + capabilities_.settling;
    auto sent = co_await set(setting.set);
    if (!sent) co_return sent;
    reply = co_await link_.query(setting.query, kReplyTime);
    if (reply && matches(setting, reply->text)) {
      apply(setting, reply->text, got);
      co_return Result<>();
    }
    if (!reply && is_fatal(reply.error().code)) break;
  }
  if (!reply) co_return fail(reply.error());
  co_return fail(Errc::refused, "{}: the meter does not take the {}: wanted {}, got {}",
                 link_.name(), setting.name, setting.wanted, printable(reply->text));
}

Task<Result<LcrSettings>> Lcr6100::configure(LcrSettings settings) {
  MeterState wanted(std::move(settings), CorrectionsOn());
  co_return co_await set_up(std::move(wanted), false);
}

Task<Result<LcrSettings>> Lcr6100::restore(MeterState wanted) {
  co_return co_await set_up(std::move(wanted), true);
}

Task<Result<ReadBack>> Lcr6100::read_back(MeterState wanted) {
  co_await wake();
  ReadBack out;
  std::string query, answer;
  const auto table = read_backs_for(wanted);
  for (const Setting& setting : table) {
    if (setting.query == query && matches(setting, answer)) continue;
    // After one difference on an emptied line, the other answers are no older than that one.
    const int tries = out.equal() ? 2 : 1;
    auto reply = co_await ask_setting(setting, tries);
    if (!reply) co_return fail(reply.error());
    query = setting.query;
    answer = reply->text;
    if (!matches(setting, answer)) out.differs.emplace_back(key_of(setting.id));
  }
  co_return out;
}

// The answer that matches, or the last of `tries`, each on an emptied line.
Task<Result<Reply>> Lcr6100::ask_setting(const Setting& setting, int tries) {
  Result<Reply> reply = fail(Errc::bug, "{}: not asked", link_.name());
  for (int i = 0; i < tries; ++i) {
    reply = co_await link_.query(setting.query, kReplyTime);
    if (reply && matches(setting, reply->text)) break;
    if (!reply && is_fatal(reply.error().code)) break;
    link_.mark_dirty();
  }
  co_return reply;
}

Task<Result<bool>> Lcr6100::is_established(const Setting& setting, LcrSettings& got) {
  auto reply = co_await link_.query(setting.query, kReplyTime);
  if (!reply && is_fatal(reply.error().code)) co_return fail(reply.error());
  if (!reply || !matches(setting, reply->text)) co_return false;
  apply(setting, reply->text, got);
  co_return true;
}

Task<Result<LcrSettings>> Lcr6100::set_up(MeterState wanted, bool look_first) {
  const LcrSettings& settings = wanted.settings;
  auto valid = check(settings);
  if (!valid) co_return fail(valid.error());
  co_await wake();
  LcrSettings got = settings;
  configured_ = false;
  settled_ = MonoTime{};
  const auto table = settings_for(wanted);
  for (const Setting& setting : table) {
    // The trigger comes last. Sending it starts a new conversion, when the others have settled.
    const bool changed = settled_ > MonoTime{};
    const bool last = setting.id == SettingId::trigger;
    if (last && settled_ > clock_.now()) co_await clock_.wait_until(settled_);
    if (look_first && !(last && changed)) {
      auto there = co_await is_established(setting, got);
      if (!there) co_return fail(there.error());
      if (*there) continue;
    }
    auto taken = co_await establish(setting, got);
    if (!taken) co_return fail(taken.error());
  }
  settings_ = settings;
  conversion_ = capabilities_.conversion_time(settings);
  link_.set_patience(std::max<Duration>(2s, conversion_ + conversion_ / 2));
  // A meter that did not start anew ends the conversion from before within this time. Not on its
  // edge, where an answer may be of either side.
  const Duration old = conversion_ - kPace + Pace::kEarlier;
  const MonoTime clean = clock_.now() + std::max<Duration>(0s, old);
  pace_.restart(clean, conversion_);
  last_poll_ = clean + conversion_ - settings.poll_interval.value_or(Duration{});
  last_values_.clear();
  last_fresh_ = MonoTime{};
  slow_ = 0;
  configured_ = true;
  co_return got;
}

// The meter counts as slow after five readings in a row that took far too long for the setting.
void Lcr6100::note_duration(Duration d) {
  const bool fast = settings_.aperture == Aperture::fast && settings_.frequency.si() >= kFastFrom;
  const bool slow = to_seconds(d) > kSlowFactor * to_seconds(conversion_);
  slow_ = judges_pace_ && fast && slow ? slow_ + 1 : 0;
}

Result<LcrReading> Lcr6100::reading(const Reply& reply, std::string_view command, bool& fresh) {
  const auto line = parse_reading(reply.text);
  if (!line || line->numbers < 2) {
    link_.mark_dirty();
    return fail(Errc::garbled, "{}: {} -> \"{}\" is not a reading", link_.name(), command,
                printable(reply.text));
  }
  fresh = line->values != last_values_;
  if (fresh) last_values_ = line->values;
  LcrReading out;
  out.primary = line->primary;
  out.secondary = line->secondary;
  out.function = settings_.function;
  out.flags = line->flags;
  out.fresh = fresh;
  out.status = line->status;
  out.asked = reply.asked;
  out.first_byte = reply.first_byte;
  out.last_byte = reply.last_byte;
  if (line->primary && is_out_of_range(settings_, *line->primary)) {
    out.flags |= lcr_flag::kOutOfRange;
  }
  if (link_.take_resynced()) out.flags |= lcr_flag::kAfterResync;
  out.slow = slow_ >= kSlowReadings;
  return out;
}

Task<Result<LcrReading>> Lcr6100::measure() {
  if (!configured_) {
    co_return fail(Errc::invalid_request, "{}: the meter is not configured", link_.name());
  }
  if (settings_.trigger == LcrTrigger::bus) co_return co_await trigger();
  co_return co_await poll();
}

// *TRG itself sends the reading. A FETC? after it would leave a second line unread.
Task<Result<LcrReading>> Lcr6100::trigger() {
  const Duration timeout = std::max<Duration>(5s, 3 * conversion_);
  auto reply = co_await link_.query("*TRG", timeout);
  if (!reply) co_return fail(reply.error());
  note_duration(reply->last_byte - reply->asked);
  bool changed = true;
  auto out = reading(*reply, "*TRG", changed);
  if (out) out->fresh = true;
  co_return out;
}

MonoTime Lcr6100::next_poll(MonoTime now) const {
  if (!settings_.poll_interval) return pace_.next_poll(now);
  return std::max(now, last_poll_ + std::max<Duration>(1ms, *settings_.poll_interval));
}

Task<Result<LcrReading>> Lcr6100::poll() {
  const MonoTime begin = clock_.now();
  const MonoTime give_up = begin + 3 * conversion_;
  // Only consecutive readings without a pause between them show the meter's speed.
  const bool pauses = settings_.poll_interval.value_or(Duration{}) > conversion_;
  if (pauses || begin - last_poll_ > conversion_) last_fresh_ = MonoTime{};
  const Duration timeout = std::max<Duration>(kReplyTime, 2 * conversion_);
  while (true) {
    const MonoTime now = clock_.now();
    const MonoTime at = next_poll(now);
    if (at > now) co_await clock_.wait_until(at);
    last_poll_ = clock_.now();
    auto reply = co_await link_.query("FETC?", timeout);
    if (!reply) co_return fail(reply.error());
    bool fresh = false;
    auto out = reading(*reply, "FETC?", fresh);
    if (!out) co_return out;
    if (fresh) {
      pace_.fresh(reply->asked, reply->first_byte);
      if (last_fresh_ != MonoTime{}) note_duration(reply->first_byte - last_fresh_);
      last_fresh_ = reply->first_byte;
      co_return out;
    }
    pace_.stale(reply->asked);
    if (reply->asked >= give_up) co_return out;
  }
}

// The meter sends lines of text; the last one says `pass` or `fail`.
Task<Result<>> Lcr6100::await_verdict(std::string_view command) {
  const MonoTime end = clock_.now() + kCorrectionTime;
  auto line = co_await link_.query(command, kCorrectionTime);
  while (line) {
    const std::string word = lower_case(line->text);
    if (word.find("pass") != word.npos) co_return Result<>();
    if (word.find("fail") != word.npos) {
      co_return fail(Errc::refused, "{}: {} -> \"{}\"; check fixture and leads, then repeat it",
                     link_.name(), command, printable(line->text));
    }
    line = co_await link_.next_line(command, end - clock_.now());
  }
  link_.mark_dirty();
  if (line.error().code != Errc::no_reply) co_return fail(line.error());
  co_return fail(
      Errc::no_reply,
      "{}: {} -> no verdict in {} s; the meter may still measure: wait until its display "
      "says that it is done, then repeat it",
      link_.name(), command, kCorrectionTime / 1s);
}

Task<Result<>> Lcr6100::correct(CorrectionKind kind) {
  co_await wake();
  configured_ = false;  // the meter shows another page, and the person may have used its keys
  const std::string node = kind == CorrectionKind::open ? "CORR:OPEN" : "CORR:SHOR";
  const std::string command = node + ":LCR";
  link_.set_patience(kCorrectionTime);
  auto verdict = co_await await_verdict(command);
  // A meter that gave no verdict may still be busy with the correction.
  const bool answered = verdict || verdict.error().code == Errc::refused;
  if (answered) link_.set_patience(std::max<Duration>(2s, conversion_ + conversion_ / 2));
  if (!verdict) co_return verdict;
  const SettingId id =
      kind == CorrectionKind::open ? SettingId::open_correction : SettingId::short_correction;
  const Setting state(id, "correction state", node + ":STAT", "ON");
  LcrSettings unused;
  co_return co_await establish(state, unused);
}

// nullopt: the meter leaves the question unanswered, because it has no such setting.
Task<Result<std::optional<bool>>> Lcr6100::ask_switch(std::string_view query) {
  for (int i = 0; i < kTries; ++i) {
    auto reply = co_await link_.query(query, kReplyTime);
    if (!reply && is_fatal(reply.error().code)) co_return fail(reply.error());
    if (!reply) continue;
    if (const auto on = parse_switch(reply->text)) co_return on;
    link_.mark_dirty();
  }
  co_return std::nullopt;
}

Task<Result<CorrectionsOn>> Lcr6100::corrections() {
  co_await wake();
  CorrectionsOn out;
  auto open = co_await ask_switch("CORR:OPEN:STAT?");
  if (!open) co_return fail(open.error());
  out.open = *open;
  if (!out.open) co_return out;  // the meter does not know the other question either
  auto short_circuit = co_await ask_switch("CORR:SHOR:STAT?");
  if (!short_circuit) co_return fail(short_circuit.error());
  out.short_circuit = *short_circuit;
  co_return out;
}

Task<Result<>> Lcr6100::resync() {
  co_return co_await link_.resync();
}

Task<Result<>> Lcr6100::make_safe() {
  co_await wake();
  configured_ = false;
  auto internal = co_await set("TRIG:SOUR INT");
  if (!internal) co_return internal;
  co_return co_await set("UNLOCK");
}

}  // namespace lcrig::lcr6100
