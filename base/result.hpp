// SPDX-License-Identifier: Apache-2.0
// Errors that a cable, an instrument, a file or a person can cause. Exceptions are for bugs only.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace lcrig {

// Each value says what the operator should do; `Error::what` names device and exchange.
enum class Errc {
  no_reply,  // did not start to answer in time: check cable, power, front-panel port choice
  reply_cut_off,  // stopped in the middle of an answer: check cable
  garbled,  // an answer that does not parse: wrong instrument or line noise
  refused,  // the instrument said no, or did not take a setting
  unsupported,  // this instrument cannot do that at all: use another one, or ask for something else
  disconnected,  // the port went away: plug it in again
  busy,  // somebody else owns it: stop the other program
  limit_tripped,  // a limit of the protocol or the machine was reached
  not_standing,  // a frame did not confirm that it stands: use the E-stop
  frame_fault,  // a frame reports a fault (E-stop, drive) or does not obey: look at it, clear it
  invalid_request,  // the request (file, flag, message) is wrong: correct it
  aborted,  // a person or a signal stopped it
  io,  // the operating system refused: read the message
  bug,  // ours: report it with the wire log
};
std::string_view to_string(Errc code);

struct Error {
  Error() = default;
  Error(Errc c, std::string w)
      : code(c), what(std::move(w)) {}  // no aggregate: see the g++ 12 notes
  Errc code = Errc::bug;
  std::string what;
};

// A value or an Error. tl::expected until g++ has std::expected under -std=c++20; only this class
// knows. A class of its own, not an alias, so that the compiler can refuse a dropped result.
template <class T = void>
class [[nodiscard]] Result : public tl::expected<T, Error> {
 public:
  using tl::expected<T, Error>::expected;
};

template <class... Args>
tl::unexpected<Error> fail(Errc code, fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(Error(code, fmt::format(format, std::forward<Args>(args)...)));
}
inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace lcrig
