// SPDX-License-Identifier: Apache-2.0
// Fault injection for tests/scenario/nth_operation_test.cpp: the nth read or write of all wrapped
// transports fails with an I/O error.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "base/clock.hpp"
#include "drivers/transport.hpp"

namespace lcrig {

// Counts the operations of all wires of a bench, in the order in which they begin.
struct NthOperation {
  explicit NthOperation(std::int64_t n) : fails_at(n) {}
  std::int64_t fails_at;  // negative: none fails
  std::int64_t begun = 0;
  bool reached = false;
  bool next() {
    const bool now = begun++ == fails_at;
    reached = reached || now;
    return now;
  }
};

class FailingTransport final : public Transport {
 public:
  FailingTransport(std::unique_ptr<Transport> inner, NthOperation& nth)
      : inner_(std::move(inner)), nth_(nth) {}

  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override {
    if (nth_.next()) co_return fail(Errc::io, "{}: Input/output error", name());
    auto n = co_await inner_->read_some(buffer, deadline);
    co_return n;
  }
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override {
    if (nth_.next()) co_return fail(Errc::io, "{}: Input/output error", name());
    auto written = co_await inner_->write_all(bytes, deadline);
    co_return written;
  }
  void close() override { inner_->close(); }
  const std::string& name() const override { return inner_->name(); }

 private:
  std::unique_ptr<Transport> inner_;
  NthOperation& nth_;
};

}  // namespace lcrig
