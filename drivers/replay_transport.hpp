// SPDX-License-Identifier: Apache-2.0
// Plays a wire log: checks what is written against it and answers what was read. Answers come at
// once; the recorded times are for people. Chunk borders of the log do not matter.
#pragma once

#include <string>

#include "drivers/transport.hpp"
#include "drivers/wire_log.hpp"

namespace lcrig {

class ReplayTransport final : public Transport {
 public:
  ReplayTransport(WireLog log, Clock& clock, std::string name);

  // Errors: no_reply while the log expects a write, disconnected at its end.
  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override;
  // Errors: invalid_request, naming line, wanted and written bytes, when they differ from the log.
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override;
  void close() override { closed_ = true; }
  const std::string& name() const override { return name_; }
  // True when everything was written and read.
  bool at_end();

 private:
  std::string_view rest();  // of the current entry, which is not empty; empty: end of the log
  Result<> match(std::string_view bytes);

  WireLog log_;
  Clock& clock_;
  std::string name_;
  std::size_t entry_ = 0, offset_ = 0;
  bool closed_ = false;
};

}  // namespace lcrig
