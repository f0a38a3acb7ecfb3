// SPDX-License-Identifier: Apache-2.0
// Wraps a transport and writes a wire log (wire_log.hpp) of everything that goes through it. Used
// by the App when the configuration asks for it; the log belongs in bug reports.
#pragma once

#include <memory>
#include <string>

#include "drivers/transport.hpp"
#include "drivers/wire_log.hpp"
#include "drivers/wire_log_writer.hpp"

namespace lcrig {

class RecordingTransport final : public Transport {
 public:
  RecordingTransport(std::unique_ptr<Transport> inner, Clock& clock,
                     std::unique_ptr<WireLogWriter::File> log, const WireLogHeader& header);

  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override;
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override;
  void close() override;
  const std::string& name() const override { return inner_->name(); }

 private:
  void note(bool to_instrument, std::string_view bytes);

  std::unique_ptr<Transport> inner_;
  Clock& clock_;
  std::unique_ptr<WireLogWriter::File> log_;  // until it is closed
  MonoTime start_;
};

}  // namespace lcrig
