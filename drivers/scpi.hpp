// SPDX-License-Identifier: Apache-2.0
// Questions and answers in lines over a transport, for instruments that answer in the order in
// which they are asked. Used by the LCR-6000 driver.
//
// An answer is never paired with the wrong question. An exchange that does not end cleanly
// (time-out, cut-off, cancelled, more bytes than asked for) makes the line dirty. Before the next
// question the line is then resynchronised: drain, ask the sentinel `*IDN?`, discard every line
// until the identity comes, drain. Because the instrument answers in order, all late answers come
// before the identity.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/transport.hpp"

namespace lcrig {

// What to do about bytes that are no text.
constexpr std::string_view kLineWords =
    "check that baud rate and parity of the port are those of the instrument";

struct Reply {
  std::string text;  // without line end and surrounding blanks; never empty
  MonoTime asked, first_byte, last_byte;
};

class ScpiLink {
 public:
  ScpiLink(std::unique_ptr<Transport> transport, Clock& clock);

  // `command` has no line end and must stay alive until the task ends. Errors: no_reply,
  // reply_cut_off, garbled (a line beyond 1000 bytes), disconnected, io; `what` names the exchange.
  Task<Result<Reply>> query(std::string_view command, Duration timeout);
  Task<Result<>> send(std::string_view command);
  // The next line of an answer with several lines, after a query.
  Task<Result<Reply>> next_line(std::string_view command, Duration timeout);

  // Resynchronises the line even when it seems clean. Errors: as query.
  Task<Result<>> resync();
  // Discards pending bytes and counts the line as clean. Use it only before the identity is known.
  Task<Result<>> flush();
  // Call when the last answer made no sense; the line is then resynchronised.
  void mark_dirty() { dirty_ = true; }
  bool dirty() const { return dirty_; }
  // The identity line that a resynchronisation waits for. Until it is set, any line that looks like
  // one counts (four or more fields, two letters first).
  void set_identity(std::string text) { identity_ = std::move(text); }
  // The longest time that the instrument may be busy with one command.
  void set_patience(Duration d) { patience_ = d; }
  // True on the first call after a resynchronisation.
  bool take_resynced() { return std::exchange(resynced_, false); }
  // True if, since the last call, the instrument repeated a command (echo) or sent a line that
  // nobody asked for (stray).
  bool take_echo_seen() { return std::exchange(echo_seen_, false); }
  bool take_stray_seen() { return std::exchange(stray_seen_, false); }

  // Bytes came since the last clean answer, and some are no text: what a wrong baud rate or parity
  // looks like.
  bool heard_no_text() const { return heard_no_text_; }

  void close() { transport_->close(); }
  const std::string& name() const { return transport_->name(); }

 private:
  Task<Result<>> write_line(std::string_view command);
  Task<Result<Reply>> read_line(MonoTime deadline);
  Task<Result<std::size_t>> fill(MonoTime deadline);
  Task<Result<Reply>> exchange(std::string_view command, Duration timeout);
  Task<Result<>> prepare();
  Task<Result<>> drain(Duration quiet);
  Task<Result<bool>> await_identity();
  bool take_line(std::string& out);
  bool only_echo();
  bool is_identity(std::string_view line) const;
  tl::unexpected<Error> named(std::string_view command, const Error& error, Duration timeout) const;

  std::unique_ptr<Transport> transport_;
  Clock& clock_;
  std::string in_, out_, last_sent_, identity_;
  std::array<char, 512> chunk_{};
  MonoTime first_byte_{}, last_byte_{};
  Duration patience_ = std::chrono::seconds(2);
  int open_identities_ = 0;  // number of `*IDN?` not yet answered
  bool dirty_ = false, resynced_ = false, echo_seen_ = false, stray_seen_ = false;
  bool heard_no_text_ = false;
};

}  // namespace lcrig
