// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording_transport.hpp"

#include <utility>

#include "base/clock.hpp"

namespace lcrig {

WireRecord::WireRecord(std::unique_ptr<WireLogWriter::File> file, Clock& clock,
                       const WireLogHeader& header, std::size_t most)
    : file_(std::move(file)), clock_(clock), start_(clock.now()), left_(most) {
  add(format_wire_header(header));
}

void WireRecord::begin() {
  if (!std::exchange(begun_, true)) return;
  add(fmt::format("# the port was opened at {} ns\n", age().count()));
}

void WireRecord::note(bool to_instrument, std::string_view bytes) {
  add(format_wire_entry(age().count(), to_instrument, bytes));
}

void WireRecord::add(const std::string& text) {
  if (left_ == 0) return;
  if (text.size() < left_) {
    left_ -= text.size();
    return file_->add(text);
  }
  left_ = 0;
  file_->add("# the log is full: what follows is left out\n");
}

RecordingTransport::RecordingTransport(std::unique_ptr<Transport> inner,
                                       std::shared_ptr<WireRecord> log)
    : inner_(std::move(inner)), log_(std::move(log)) {
  log_->begin();
}

void RecordingTransport::close() {
  inner_->close();
  log_.reset();
}

void RecordingTransport::note(bool to_instrument, std::string_view bytes) {
  if (log_) log_->note(to_instrument, bytes);
}

Task<Result<std::size_t>> RecordingTransport::read_some(std::span<char> buffer, MonoTime deadline) {
  auto r = co_await inner_->read_some(buffer, deadline);
  if (r) note(false, std::string_view(buffer.data(), *r));
  co_return r;
}

// Logs the bytes before sending them, so that the log shows what was tried when the port hangs.
Task<Result<>> RecordingTransport::write_all(std::string_view bytes, MonoTime deadline) {
  note(true, bytes);
  co_return co_await inner_->write_all(bytes, deadline);
}

}  // namespace lcrig
