// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording_transport.hpp"

namespace lcrig {

RecordingTransport::RecordingTransport(std::unique_ptr<Transport> inner, Clock& clock,
                                       std::unique_ptr<WireLogWriter::File> log,
                                       const WireLogHeader& header)
    : inner_(std::move(inner)), clock_(clock), log_(std::move(log)), start_(clock.now()) {
  log_->add(format_wire_header(header));
}

void RecordingTransport::close() {
  inner_->close();
  log_.reset();
}

void RecordingTransport::note(bool to_instrument, std::string_view bytes) {
  if (log_) log_->add(format_wire_entry((clock_.now() - start_).count(), to_instrument, bytes));
}

Task<Result<std::size_t>> RecordingTransport::read_some(std::span<char> buffer, MonoTime deadline) {
  auto r = co_await inner_->read_some(buffer, deadline);
  if (r) note(false, std::string_view(buffer.data(), *r));
  co_return r;
}

// Noted before it is sent, so that the log shows what was tried when the port hangs.
Task<Result<>> RecordingTransport::write_all(std::string_view bytes, MonoTime deadline) {
  note(true, bytes);
  co_return co_await inner_->write_all(bytes, deadline);
}

}  // namespace lcrig
