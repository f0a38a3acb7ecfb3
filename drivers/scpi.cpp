// SPDX-License-Identifier: Apache-2.0
#include "drivers/scpi.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "base/clock.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMaxLine = 1000;  // bytes; the longest known answer has 70
constexpr Duration kWriteTime = 2s;
constexpr Duration kQuiet = 50ms;  // after this long without a byte the line is drained
constexpr Duration kDrainAtMost = 1s;  // a meter that sends unasked is never quiet
constexpr std::string_view kSentinel = "*IDN?";

bool is_text(char c) {
  return (c >= ' ' && c <= '~') || c == '\r' || c == '\n' || c == '\t';
}

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

}  // namespace

ScpiLink::ScpiLink(std::unique_ptr<Transport> transport, Clock& clock)
    : transport_(std::move(transport)), clock_(clock) {
  in_.reserve(2 * kMaxLine);
  out_.reserve(128);
}

bool ScpiLink::is_identity(std::string_view line) const {
  // When the LF before the identity was lost, the identity is only the end of the line.
  if (!identity_.empty()) return line.ends_with(identity_);
  return line.size() > 2 && is_letter(line[0]) && is_letter(line[1]) &&
         std::ranges::count(line, ',') >= 3;
}

tl::unexpected<Error> ScpiLink::named(std::string_view command, const Error& error,
                                      Duration timeout) const {
  if (error.code == Errc::no_reply) {
    return fail(Errc::no_reply, "{}: {} -> no reply in {} ms", name(), command, timeout / 1ms);
  }
  if (error.code == Errc::reply_cut_off || error.code == Errc::garbled) {
    return fail(error.code, "{}: {} -> {}", name(), command, error.what);
  }
  return fail(error.code, "{} (during {})", error.what, command);
}

Task<Result<std::size_t>> ScpiLink::fill(MonoTime deadline) {
  auto n = co_await transport_->read_some(chunk_, deadline);
  if (!n) co_return n;
  last_byte_ = clock_.now();
  if (in_.empty()) first_byte_ = last_byte_;
  in_.append(chunk_.data(), *n);
  const std::string_view bytes(chunk_.data(), *n);
  heard_no_text_ = heard_no_text_ || !std::ranges::all_of(bytes, is_text);
  co_return n;
}

// Takes the next line that is not blank; false when there is none yet.
bool ScpiLink::take_line(std::string& out) {
  while (true) {
    const auto end = in_.find('\n');
    if (end == in_.npos) return false;
    out = trimmed(std::string_view(in_).substr(0, end));
    in_.erase(0, end + 1);
    if (!out.empty()) return true;
  }
}

Task<Result<Reply>> ScpiLink::read_line(MonoTime deadline) {
  Reply reply;
  while (!take_line(reply.text)) {
    if (in_.size() > kMaxLine) co_return fail(Errc::garbled, "a line of more than 1000 bytes");
    auto n = co_await fill(deadline);
    if (n) continue;
    if (n.error().code == Errc::no_reply && !trimmed(in_).empty()) {
      co_return fail(Errc::reply_cut_off, "reply cut off after \"{}\"", printable(in_));
    }
    co_return fail(n.error());
  }
  reply.first_byte = first_byte_;
  reply.last_byte = last_byte_;
  co_return reply;
}

Task<Result<>> ScpiLink::write_line(std::string_view command) {
  out_.assign(command);
  out_ += '\n';
  last_sent_ = command;
  co_return co_await transport_->write_all(out_, clock_.now() + kWriteTime);
}

// True when all pending bytes are complete lines that repeat what was sent: then the meter's
// handshake is on.
bool ScpiLink::only_echo() {
  std::string_view rest = in_;
  while (!rest.empty()) {
    const auto end = rest.find('\n');
    if (end == rest.npos || trimmed(rest.substr(0, end)) != last_sent_) return false;
    rest.remove_prefix(end + 1);
  }
  return true;
}

// Empties the line before a question, because pending bytes cannot be its answer.
Task<Result<>> ScpiLink::prepare() {
  if (!dirty_) {
    auto stray = co_await fill(clock_.now());
    while (stray && *stray == chunk_.size()) stray = co_await fill(clock_.now());
    if (!stray && stray.error().code != Errc::no_reply) co_return fail(stray.error());
    if (in_.empty()) co_return Result<>();
    if (only_echo()) {
      echo_seen_ = true;
      in_.clear();
      co_return Result<>();
    }
    stray_seen_ = true;
  }
  co_return co_await resync();
}

Task<Result<Reply>> ScpiLink::exchange(std::string_view command, Duration timeout) {
  dirty_ = true;  // until the answer is complete, so also after a cancellation
  const bool identity = command == kSentinel;
  if (identity) ++open_identities_;
  const MonoTime asked = clock_.now();
  auto written = co_await write_line(command);
  if (!written) co_return fail(written.error());
  auto reply = co_await read_line(asked + timeout);
  if (reply && reply->text == command) {
    echo_seen_ = true;
    reply = co_await read_line(asked + timeout);
  }
  if (!reply) co_return reply;
  reply->asked = asked;
  if (identity) --open_identities_;
  if (!in_.empty()) stray_seen_ = true;
  dirty_ = !in_.empty();
  heard_no_text_ = heard_no_text_ && !std::ranges::all_of(reply->text, is_text);
  co_return reply;
}

Task<Result<Reply>> ScpiLink::query(std::string_view command, Duration timeout) {
  auto ready = co_await prepare();
  if (!ready) co_return fail(ready.error());
  auto reply = co_await exchange(command, timeout);
  if (!reply) co_return named(command, reply.error(), timeout);
  co_return reply;
}

Task<Result<Reply>> ScpiLink::next_line(std::string_view command, Duration timeout) {
  const MonoTime asked = clock_.now();
  dirty_ = true;
  auto reply = co_await read_line(asked + timeout);
  if (!reply) co_return named(command, reply.error(), timeout);
  reply->asked = asked;
  dirty_ = !in_.empty();
  co_return reply;
}

Task<Result<>> ScpiLink::send(std::string_view command) {
  auto written = co_await write_line(command);
  if (written) co_return written;
  dirty_ = true;
  co_return named(command, written.error(), kWriteTime);
}

Task<Result<>> ScpiLink::drain(Duration quiet) {
  const MonoTime end = clock_.now() + kDrainAtMost;
  while (clock_.now() < end) {
    in_.clear();
    auto n = co_await fill(std::min(end, clock_.now() + quiet));
    if (n) continue;
    if (n.error().code != Errc::no_reply) co_return fail(n.error());
    break;
  }
  in_.clear();
  co_return Result<>();
}

Task<Result<>> ScpiLink::flush() {
  auto drained = co_await drain(kQuiet);
  if (drained) dirty_ = false;
  co_return drained;
}

// True when all sentinels were answered, or when one was and the line is quiet: the others are
// lost.
Task<Result<bool>> ScpiLink::await_identity() {
  MonoTime deadline = clock_.now() + patience_;
  bool seen = false;
  while (true) {
    auto line = co_await read_line(deadline);
    if (line) {
      if (!is_identity(line->text)) continue;
      seen = true;
      if (--open_identities_ <= 0) co_return true;
      deadline = clock_.now() + patience_;
      continue;
    }
    const Errc code = line.error().code;
    in_.clear();
    if (code == Errc::garbled) continue;
    if (code != Errc::no_reply && code != Errc::reply_cut_off) co_return fail(line.error());
    co_return seen;
  }
}

Task<Result<>> ScpiLink::resync() {
  dirty_ = true;
  for (int attempt = 0; attempt < 3; ++attempt) {
    auto drained = co_await drain(kQuiet);
    if (!drained) co_return drained;
    ++open_identities_;
    // The last command may have been cut off, so later attempts send a LF first to end it.
    const std::string_view sentinel = attempt == 0 ? "*IDN?" : "\n*IDN?";
    auto written = co_await write_line(sentinel);
    if (!written) co_return written;
    auto found = co_await await_identity();
    if (!found) co_return fail(found.error());
    if (!*found) continue;
    drained = co_await drain(kQuiet);
    if (!drained) co_return drained;
    open_identities_ = 0;
    dirty_ = false;
    resynced_ = true;
    co_return Result<>();
  }
  if (heard_no_text_) {
    co_return fail(Errc::no_reply, "{}: *IDN? -> bytes that are no answer: {}", name(), kLineWords);
  }
  co_return fail(Errc::no_reply, "{}: *IDN? -> no reply; the line cannot be resynchronised",
                 name());
}

}  // namespace lcrig
