// SPDX-License-Identifier: Apache-2.0
// Result<T>, the return type of everything that a cable, an instrument, a file or a person can make
// fail. Exceptions are for bugs only.
#pragma once

#include <fmt/core.h>

#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "base/enum_words.hpp"

namespace lcrig {

// Each value tells the operator what to do; `Error::what` names the device and the exchange.
enum class Errc {
  no_reply,  // no answer began in time: check cable, power, the port chosen on the front panel
  reply_cut_off,  // the answer stopped in the middle: check the cable
  garbled,  // the answer does not parse: wrong instrument or line noise
  refused,  // the instrument said no, or did not take a setting
  unsupported,  // this instrument cannot do that at all: use another one, or ask for something else
  disconnected,  // the port went away: plug it in again
  busy,  // another program or run uses it: end that one first
  limit_tripped,  // a limit of the protocol or the machine was reached
  not_standing,  // the frame did not confirm that it stands: use the E-stop
  frame_fault,  // the frame reports a fault (E-stop, drive) or does not obey: inspect, clear
  invalid_request,  // the request (file, flag, message) is wrong: correct it
  aborted,  // a person or a signal stopped it
  io,  // the operating system refused: read the message
  bug,  // a bug of lcrig: report it with the wire log
};
template <>
inline constexpr EnumWords<14> kWordsOf<Errc>{"no_reply",
                                              "reply_cut_off",
                                              "garbled",
                                              "refused",
                                              "unsupported",
                                              "disconnected",
                                              "busy",
                                              "limit_tripped",
                                              "not_standing",
                                              "frame_fault",
                                              "invalid_request",
                                              "aborted",
                                              "io",
                                              "bug"};

struct Error {
  Error() = default;
  Error(Errc c, std::string w)
      : code(c), what(std::move(w)) {}  // a constructor, since g++ 12 miscompiles aggregates in
                                        // coroutines
  Errc code = Errc::bug;
  std::string what;
  std::string detail;  // more lines for a person at a terminal, such as the wrong line of a file
  std::string database;  // path of the database that the error is about; empty: not about a
                         // database
  bool hands_off = false;  // the reason why nothing moves any more (FrameDrive::hands_off)
};

// A value or an Error. Only this class knows that tl::expected is behind it, so that std::expected
// can replace it later. It is a class and not an alias so that [[nodiscard]] applies to it.
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

// Moves the value of `from` into `to`, or returns its error.
template <class T, class Kept>
Result<> keep(Result<T> from, Kept& to) {
  if (!from) return fail(std::move(from.error()));
  to = std::move(*from);
  return {};
}

}  // namespace lcrig
