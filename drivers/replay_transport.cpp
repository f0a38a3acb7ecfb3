// SPDX-License-Identifier: Apache-2.0
#include "drivers/replay_transport.hpp"

#include <algorithm>

namespace lcrig {

ReplayTransport::ReplayTransport(WireLog log, Clock& clock, std::string name)
    : log_(std::move(log)), clock_(clock), name_(std::move(name)) {}

std::string_view ReplayTransport::rest() {
  while (entry_ < log_.entries.size()) {
    const std::string_view bytes = log_.entries[entry_].bytes;
    if (offset_ < bytes.size()) return bytes.substr(offset_);
    ++entry_;
    offset_ = 0;
  }
  return {};
}

bool ReplayTransport::at_end() {
  return rest().empty();
}

Task<Result<std::size_t>> ReplayTransport::read_some(std::span<char> buffer, MonoTime deadline) {
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

Result<> ReplayTransport::match(std::string_view bytes) {
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

Task<Result<>> ReplayTransport::write_all(std::string_view bytes, MonoTime) {
  co_return match(bytes);
}

}  // namespace lcrig
