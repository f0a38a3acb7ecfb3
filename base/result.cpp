// SPDX-License-Identifier: Apache-2.0
#include "base/result.hpp"

namespace lcrig {

std::string_view to_string(Errc code) {
  switch (code) {
    case Errc::no_reply: return "no_reply";
    case Errc::reply_cut_off: return "reply_cut_off";
    case Errc::garbled: return "garbled";
    case Errc::refused: return "refused";
    case Errc::unsupported: return "unsupported";
    case Errc::disconnected: return "disconnected";
    case Errc::busy: return "busy";
    case Errc::limit_tripped: return "limit_tripped";
    case Errc::not_standing: return "not_standing";
    case Errc::frame_fault: return "frame_fault";
    case Errc::invalid_request: return "invalid_request";
    case Errc::aborted: return "aborted";
    case Errc::io: return "io";
    case Errc::bug: return "bug";
  }
  return "bug";
}

}  // namespace lcrig
