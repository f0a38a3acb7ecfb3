// SPDX-License-Identifier: Apache-2.0
#include "storage/row_hash.hpp"

#include <openssl/evp.h>

#include <bit>
#include <stdexcept>

namespace lcrig {

namespace {

constexpr std::size_t kBuffer = 8192;

// libcrypto fails here only without memory or without SHA-256, so there is nothing to recover.
void check(int ok) {
  if (ok != 1) throw std::runtime_error("libcrypto: SHA-256 failed");
}

}  // namespace

std::string to_hex(std::span<const unsigned char> bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  out.reserve(2 * bytes.size());
  for (const unsigned char b : bytes) {
    out += kDigits[b >> 4U];
    out += kDigits[b & 15U];
  }
  return out;
}

std::string sha256_hex(std::string_view bytes) {
  Sha256 digest;
  check(EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr));
  return to_hex(digest);
}

void RowHash::Free::operator()(evp_md_ctx_st* c) const {
  EVP_MD_CTX_free(c);
}

RowHash::RowHash() : context_(EVP_MD_CTX_new()) {
  if (!context_) throw std::bad_alloc();
  buffer_.reserve(kBuffer + 256);
}

void RowHash::start(std::span<const unsigned char> previous) {
  check(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr));
  buffer_.assign(previous.begin(), previous.end());
}

void RowHash::byte(char c) {
  buffer_ += c;
  if (buffer_.size() >= kBuffer) flush();
}

void RowHash::number(std::uint64_t value) {
  char bytes[8];
  for (unsigned i = 0; i < 8; ++i) bytes[i] = static_cast<char>(value >> (56U - 8U * i));
  buffer_.append(bytes, sizeof bytes);
}

void RowHash::integer(std::int64_t value) {
  byte('i');
  number(static_cast<std::uint64_t>(value));
}

void RowHash::real(double value) {
  byte('r');
  number(std::bit_cast<std::uint64_t>(value));
}

void RowHash::text(std::string_view value) {
  byte('t');
  number(value.size());
  buffer_.append(value);
}

void RowHash::flush() {
  check(EVP_DigestUpdate(context_.get(), buffer_.data(), buffer_.size()));
  buffer_.clear();
}

Sha256 RowHash::finish() {
  flush();
  Sha256 digest;
  check(EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr));
  return digest;
}

}  // namespace lcrig
