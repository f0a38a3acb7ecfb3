// SPDX-License-Identifier: Apache-2.0
// SHA-256, and the canonical bytes of stored rows that the hash chain (storage/chain.hpp) covers.
// Also used where texts are stored once, under their hash (queue, specimens).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace lcrig {

using Sha256 = std::array<unsigned char, 32>;

std::string sha256_hex(std::string_view bytes);
std::string to_hex(std::span<const unsigned char> bytes);

// Canonical bytes: a row is its table's tag and its values in the order of the columns. A value is
// 'n' (NULL), 'i' + 8 bytes (integer), 'r' + 8 bytes (IEEE 754), or 't' + 8 bytes length + bytes.
// Numbers are big-endian. The bytes depend only on the stored values, not on how SQLite packs them.
class RowHash {
 public:
  RowHash();
  void start(std::span<const unsigned char> previous);  // begins a new hash with `previous`
  void row(char table_tag) { byte(table_tag); }
  void null() { byte('n'); }
  void integer(std::int64_t value);
  void real(double value);
  void text(std::string_view value);
  Sha256 finish();

 private:
  void byte(char c);
  void number(std::uint64_t value);
  void flush();

  struct Free {
    void operator()(evp_md_ctx_st* c) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
  std::string buffer_;
};

}  // namespace lcrig
