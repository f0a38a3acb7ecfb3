// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>

#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {

void require(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error(what);
}

void require_good_message(const Error& error) {
  // bytes; texts are cut at 2000 characters, and escapes make them longer
  constexpr std::size_t kLongest = 16'384;
  require(!error.what.empty(), "an empty message");
  require(error.what.size() <= kLongest, "a message of " + std::to_string(error.what.size()));
  require(error.what == printable(error.what), "a message that steers a terminal: " + error.what);
  require(error.code != Errc::bug, "called a bug: " + error.what);
}

}  // namespace lcrig::fuzz
