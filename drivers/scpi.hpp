// SPDX-License-Identifier: Apache-2.0
// Lines and questions over a transport, for instruments that answer in the order they are asked.
//
// An answer is never paired with another question: whenever an exchange did not end cleanly
// (time-out, cut-off, cancelled, more bytes than asked for) the line is dirty, and the next
// question is preceded by a resynchronisation: drain, ask the sentinel `*IDN?`, throw every line
// away until the identity came, drain. Because the instrument answers in order, whatever was late
// came before.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/transport.hpp"

namespace lcrig {

struct Reply {
  Reply() = default;
  std::string text;  // without line end and outer blanks; never empty
  MonoTime asked, first_byte, last_byte;
};

class ScpiLink {
 public:
  ScpiLink(std::unique_ptr<Transport> transport, Clock& clock);

  // `command` without line end; it must stay alive until the task ends. Errors: no_reply,
  // reply_cut_off, garbled (a line beyond 1000 bytes), disconnected, io; `what` names the exchange.
  Task<Result<Reply>> query(std::string_view command, Duration timeout);
  Task<Result<>> send(std::string_view command);
  // The next line of an answer with several lines, without asking. After a query.
  Task<Result<Reply>> next_line(std::string_view command, Duration timeout);

  // Makes the line clean, also when it seems to be. Errors as in query.
  Task<Result<>> resync();
  // The last answer made no sense: do not trust what follows either.
  void mark_dirty() { dirty_ = true; }
  bool dirty() const { return dirty_; }
  // Identity line to wait for in a resynchronisation; until it is known, anything that looks like
  // one (four fields or more, begins with two letters).
  void set_identity(std::string text) { identity_ = std::move(text); }
  // The longest time the instrument may be busy with one command.
  void set_patience(Duration d) { patience_ = d; }
  // True once after a resynchronisation.
  bool take_resynced();
  // The instrument repeats commands, or sends lines unasked (since the last call).
  bool take_echo_seen();
  bool take_stray_seen();

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
  int open_identities_ = 0;  // `*IDN?` whose answers are still due
  bool dirty_ = false, resynced_ = false, echo_seen_ = false, stray_seen_ = false;
};

}  // namespace lcrig
