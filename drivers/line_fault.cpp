// SPDX-License-Identifier: Apache-2.0
#include "drivers/line_fault.hpp"

namespace lcrig {

std::string spoiled(std::string bytes, LineFault::Kind kind) {
  using Kind = LineFault::Kind;
  const auto is_text = [](char c) { return c != '\r' && c != '\n'; };
  switch (kind) {
    case Kind::drop: return {};
    case Kind::cut: bytes.resize(bytes.size() / 2); return bytes;
    case Kind::twice: return bytes + bytes;
    case Kind::garble:
      for (std::size_t i = 1; i < bytes.size(); i += 3) {
        if (is_text(bytes[i])) bytes[i] = static_cast<char>(bytes[i] ^ 0x41);
      }
      return bytes;
    case Kind::none:
    case Kind::delay:
    case Kind::echo: break;
  }
  return bytes;
}

void LineNoise::spoil(std::string& bytes, double byte_probability) {
  if (byte_probability <= 0) return;
  // Made from 53 bits explicitly, so that every standard library gives the same numbers.
  const auto unit = [this] { return static_cast<double>(random_() >> 11U) * 0x1p-53; };
  for (char& c : bytes) {
    if (unit() < byte_probability) c = static_cast<char>(0x80U | (random_() & 0x7fU));
  }
}

}  // namespace lcrig
