// SPDX-License-Identifier: Apache-2.0
// libFuzzer's entry; compiled once per target with LCRIG_FUZZ_TARGET=read_control and so on. An
// exception that leaves it is a crash to libFuzzer.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lcrig::fuzz::LCRIG_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
