// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sink.hpp"

namespace lcrig {

std::string_view to_string(Instrument i) {
  return i == Instrument::lcr ? "lcr" : "frame";
}

std::string_view to_string(RunState s) {
  constexpr std::string_view kWords[] = {
      "preparing", "running", "paused", "waiting_for_operator", "waiting_for_instrument",
      "finishing", "ended"};
  return kWords[static_cast<std::size_t>(s)];
}

}  // namespace lcrig
