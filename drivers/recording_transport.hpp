// SPDX-License-Identifier: Apache-2.0
// Wraps a transport and writes a wire log (wire_log.hpp) of everything that goes through it. Used
// by the App when the configuration asks for it; the log belongs in bug reports.
#pragma once

#include <fstream>
#include <memory>
#include <string>

#include "drivers/transport.hpp"
#include "drivers/wire_log.hpp"

namespace lcrig {

class RecordingTransport final : public Transport {
 public:
  // `log` is open for writing.
  RecordingTransport(std::unique_ptr<Transport> inner, Clock& clock, std::ofstream log,
                     const WireLogHeader& header);

  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override;
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override;
  void close() override { inner_->close(); }
  const std::string& name() const override { return inner_->name(); }

 private:
  void note(bool to_instrument, std::string_view bytes);

  std::unique_ptr<Transport> inner_;
  Clock& clock_;
  std::ofstream log_;
  MonoTime start_;
};

// Creates or overwrites the file. Errors: io.
Result<std::unique_ptr<Transport>> make_recording(std::unique_ptr<Transport> inner, Clock& clock,
                                                  const std::string& path,
                                                  const WireLogHeader& header);

}  // namespace lcrig
