// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording_transport.hpp"
#include <spdlog/spdlog.h>

namespace lcrig {

RecordingTransport::RecordingTransport(std::unique_ptr<Transport> inner, Clock& clock,
                                       std::ofstream log, const WireLogHeader& header)
    : inner_(std::move(inner)), clock_(clock), log_(std::move(log)), start_(clock.now()) {
  log_ << format_wire_header(header) << std::flush;
}

// A full disk must not stop an experiment, so the log just ends with a warning.
void RecordingTransport::note(bool to_instrument, std::string_view bytes) {
  if (!log_.is_open()) return;
  log_ << format_wire_entry((clock_.now() - start_).count(), to_instrument, bytes) << std::flush;
  if (log_) return;
  spdlog::warn("{}: the wire log cannot be written any more; it ends here", name());
  log_.close();
}

Task<Result<std::size_t>> RecordingTransport::read_some(std::span<char> buffer, MonoTime deadline) {
  auto r = co_await inner_->read_some(buffer, deadline);
  if (r) note(false, std::string_view(buffer.data(), *r));
  co_return r;
}

// Logged before it is sent, so that the log shows what was tried when the port hangs.
Task<Result<>> RecordingTransport::write_all(std::string_view bytes, MonoTime deadline) {
  note(true, bytes);
  co_return co_await inner_->write_all(bytes, deadline);
}

Result<std::unique_ptr<Transport>> make_recording(std::unique_ptr<Transport> inner, Clock& clock,
                                                  const std::string& path,
                                                  const WireLogHeader& header) {
  std::ofstream log(path, std::ios::binary | std::ios::trunc);
  if (!log) return fail(Errc::io, "{}: the wire log cannot be created", path);
  return std::make_unique<RecordingTransport>(std::move(inner), clock, std::move(log), header);
}

}  // namespace lcrig
