// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sink.hpp"

namespace lcrig {

std::string_view to_string(RunState s) {
  switch (s) {
    case RunState::preparing: return "preparing";
    case RunState::running: return "running";
    case RunState::paused: return "paused";
    case RunState::waiting_for_operator: return "waiting_for_operator";
    case RunState::waiting_for_instrument: return "waiting_for_instrument";
    case RunState::finishing: return "finishing";
    case RunState::ended: return "ended";
  }
  return "ended";
}

}  // namespace lcrig
