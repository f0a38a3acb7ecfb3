// SPDX-License-Identifier: Apache-2.0
// Wraps a transport and writes a wire log (wire_log.hpp) of all its bytes. Used by the App when the
// configuration asks for it; people attach the log to bug reports.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/time.hpp"
#include "drivers/transport.hpp"
#include "drivers/wire_log.hpp"
#include "drivers/wire_log_writer.hpp"

namespace lcrig {

// One log, shared by one or more transports in succession.
class WireRecord {
 public:
  static constexpr std::size_t kUnlimited = SIZE_MAX;
  // `clock` must outlive it. After `most` bytes the log ends with a remark.
  WireRecord(std::unique_ptr<WireLogWriter::File> file, Clock& clock, const WireLogHeader& header,
             std::size_t most = kUnlimited);
  void begin();  // call it when a transport starts to use the log
  void note(bool to_instrument, std::string_view bytes);
  Duration age() const { return clock_.now() - start_; }

 private:
  void add(const std::string& text);

  std::unique_ptr<WireLogWriter::File> file_;
  Clock& clock_;
  MonoTime start_;
  std::size_t left_;
  bool begun_ = false;
};

class RecordingTransport final : public Transport {
 public:
  RecordingTransport(std::unique_ptr<Transport> inner, std::shared_ptr<WireRecord> log);

  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override;
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override;
  void close() override;
  const std::string& name() const override { return inner_->name(); }

 private:
  void note(bool to_instrument, std::string_view bytes);

  std::unique_ptr<Transport> inner_;
  std::shared_ptr<WireRecord> log_;  // empty once it is closed
};

}  // namespace lcrig
