// SPDX-License-Identifier: Apache-2.0
// Plays a wire log in driver tests: compares what is written with the log and answers what was
// read. Answers come at once, because the recorded times are only for people. How the log splits
// bytes into entries does not matter.
#pragma once

#include <string>

#include "drivers/transport.hpp"
#include "drivers/wire_log.hpp"

namespace lcrig {

class ReplayTransport final : public Transport {
 public:
  ReplayTransport(WireLog log, Clock& clock, std::string name);

  // Errors: no_reply while the log expects a write, disconnected at the end of the log.
  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override;
  // Errors: invalid_request when `bytes` differ from the log; names the line and both byte strings.
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override;
  void close() override { closed_ = true; }
  const std::string& name() const override { return name_; }
  // True when the whole log was played.
  bool at_end();

 private:
  std::string_view rest();  // unread part of the current entry; empty: end of the log
  Result<> match(std::string_view bytes);

  WireLog log_;
  Clock& clock_;
  std::string name_;
  std::size_t entry_ = 0, offset_ = 0;
  bool closed_ = false;
};

}  // namespace lcrig
