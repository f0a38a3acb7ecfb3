// SPDX-License-Identifier: Apache-2.0
// Plays a wire log in driver tests. It compares what is written with the log and answers with what
// the log read. Answers come at once, because the recorded times are only for people. How the log
// splits bytes into entries does not matter.
#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "drivers/transport.hpp"
#include "tests/support/wire_log_reader.hpp"

namespace lcrig {

class ReplayTransport final : public Transport {
 public:
  ReplayTransport(WireLog log, Clock& clock, std::string name);

  // Errors: no_reply while the log expects a write; disconnected at the end of the log.
  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override;
  // Errors: invalid_request when `bytes` differ from the log; the message names the line and both
  // byte strings.
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override;
  void close() override { closed_ = true; }
  const std::string& name() const override { return name_; }
  // True when the whole log was played.
  bool at_end() { return rest().empty(); }

 private:
  std::string_view rest();  // unread part of the current entry; empty: end of the log
  Result<> match(std::string_view bytes);

  WireLog log_;
  Clock& clock_;
  std::string name_;
  std::size_t entry_ = 0, offset_ = 0;
  bool closed_ = false;
};

inline ReplayTransport::ReplayTransport(WireLog log, Clock& clock, std::string name)
    : log_(std::move(log)), clock_(clock), name_(std::move(name)) {}

inline std::string_view ReplayTransport::rest() {
  while (entry_ < log_.entries.size()) {
    const std::string_view bytes = log_.entries[entry_].bytes;
    if (offset_ < bytes.size()) return bytes.substr(offset_);
    ++entry_;
    offset_ = 0;
  }
  return {};
}

inline Task<Result<std::size_t>> ReplayTransport::read_some(std::span<char> buffer,
                                                            MonoTime deadline) {
  const std::string_view bytes = rest();
  if (closed_ || bytes.empty()) {
    co_return fail(Errc::disconnected, "{}: the wire log ends here", name_);
  }
  if (log_.entries[entry_].to_instrument) {
    if (deadline > clock_.now()) co_await clock_.wait_until(deadline);
    co_return fail(Errc::no_reply, "{}: nothing received in time", name_);
  }
  const std::size_t n = std::min(bytes.size(), buffer.size());
  std::copy_n(bytes.data(), n, buffer.data());
  offset_ += n;
  co_return n;
}

inline Result<> ReplayTransport::match(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::string_view wanted = rest();
    if (closed_ || wanted.empty()) {
      return fail(Errc::disconnected, "{}: the wire log ends before {}", name_, quote_bytes(bytes));
    }
    const WireEntry& entry = log_.entries[entry_];
    const std::size_t n = std::min(wanted.size(), bytes.size());
    if (!entry.to_instrument || wanted.substr(0, n) != bytes.substr(0, n)) {
      return fail(Errc::invalid_request,
                  "{}: line {} of the wire log has {} {}, but {} was written", name_, entry.line,
                  entry.to_instrument ? '>' : '<', quote_bytes(wanted), quote_bytes(bytes));
    }
    offset_ += n;
    bytes.remove_prefix(n);
  }
  return {};
}

inline Task<Result<>> ReplayTransport::write_all(std::string_view bytes, MonoTime) {
  co_return match(bytes);
}

}  // namespace lcrig
