// SPDX-License-Identifier: Apache-2.0
// libFuzzer's entry point, compiled once per target with LCRIG_FUZZ_TARGET=read_control and so on.
// libFuzzer treats an escaping exception as a crash.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lcrig::fuzz::LCRIG_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
