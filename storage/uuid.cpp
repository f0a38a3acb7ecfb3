// SPDX-License-Identifier: Apache-2.0
#include "storage/uuid.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <span>

namespace lcrig {

namespace {

constexpr std::size_t kVersionAt = 14, kLength = 36;

bool is_dash_at(std::size_t i) {
  return i == 8 || i == 13 || i == 18 || i == 23;
}

// Takes 30 hex digits; version and variant are the other two.
std::string uuid_of(std::string_view hex, char version) {
  std::string out;
  out.reserve(kLength);
  for (std::size_t i = 0, next = 0; i < kLength; ++i) {
    if (is_dash_at(i)) {
      out += '-';
    } else if (i == kVersionAt) {
      out += version;
    } else if (i == 19) {
      out += '8';
    } else {
      out += hex[next++];
    }
  }
  return out;
}

}  // namespace

std::string random_uuid() {
  std::random_device random;  // the kernel's source
  std::array<unsigned char, 16> bytes{};
  for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
  return uuid_of(to_hex(bytes), '4');
}

std::string uuid_of_link(const Sha256& first_link) {
  return uuid_of(to_hex(std::span(first_link).first(15)), '8');
}

bool is_of_link(std::string_view uuid) {
  return uuid.size() == kLength && uuid[kVersionAt] == '8';
}

bool is_beginning_of_uuid(std::string_view text) {
  constexpr std::size_t kFewest = 4;
  if (text.size() < kFewest || text.size() > kLength) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool hex = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
    if (is_dash_at(i) ? c != '-' : !hex) return false;
  }
  return std::ranges::any_of(text, [](char c) { return c < '0' || c > '9'; });
}

}  // namespace lcrig
