// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/live_line.hpp"

#include <fmt/ostream.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "daemon/control/messages.hpp"

namespace lcrig::cli {

namespace {

constexpr int kBarMin = 8, kBarMax = 40;

// Foreign text as ASCII: one column for each character, and nothing that a terminal would obey.
std::string ascii(std::string_view text, std::size_t most = kLongestName) {
  std::string out;
  for (const char c : text) {
    if (out.size() == most) return out + "...";
    const auto u = static_cast<unsigned char>(c);
    if ((u & 0xc0U) == 0x80U) continue;  // a later byte of a UTF-8 character
    out += u >= 0x20 && u < 0x7f ? c : '?';
  }
  return out;
}

// "PAUSED at load". A continued run first waits outside of any step.
std::string at_step(const char* state, const char* between, const RunStatus& s) {
  return s.step_id.empty() ? state : state + (between + ascii(s.step_id));
}

std::string step_part(const RunStatus& s) {
  if (s.standstill == Standstill::not_confirmed) {
    return at_step("STANDSTILL NOT CONFIRMED: use the E-stop", "; ", s);
  }
  if (s.standstill == Standstill::unknown) {
    return at_step("STANDSTILL UNKNOWN: frame away", "; ", s);
  }
  switch (s.state) {
    case RunState::stopping: return at_step("stopping", " at ", s);
    case RunState::holding_force: return at_step("METER AWAY, holds the force", " at ", s);
    case RunState::paused: return at_step("PAUSED", " at ", s);
    case RunState::waiting_for_operator: return at_step("WAITING", " at ", s);
    case RunState::waiting_for_instrument: return at_step("INSTRUMENT AWAY", " at ", s);
    case RunState::finishing: return at_step("finishing", ": ", s);
    case RunState::preparing: return "preparing";
    case RunState::ended: return "ended";
    case RunState::running: break;
  }
  return ascii(s.step_id);
}

// The present step, and a stop or pause that was asked for.
std::string place_part(const RunStatus& s) {
  std::string out = step_part(s);
  if (s.state == RunState::finishing || s.state == RunState::ended) return out;
  if (!s.stops_after.empty()) out += ", stops after this " + ascii(s.stops_after);
  if (!s.pauses_at.empty()) out += ", pauses at the end of this " + ascii(s.pauses_at);
  return out;
}

std::string repeat_part(const RunStatus& s) {
  if (s.repeats <= 0) return "";
  return fmt::format("{}/{}", s.repeat, s.repeats);
}

std::string capacitance_part(const RunStatus& s) {
  if (!s.capacitance_F) return "";
  return fmt::format("C {} pF", format_fixed(*s.capacitance_F * 1e12, 4));
}

std::string force_part(const RunStatus& s) {
  return s.force_N ? fmt::format("F {} N", format_fixed(*s.force_N, 3)) : std::string();
}

std::string pressure_part(const RunStatus& s) {
  if (!s.pressure_Pa) return "";
  return fmt::format("P {} kPa{}", format_fixed(*s.pressure_Pa * 1e-3, 2),
                     s.pressure_on == PressureOn::disc ? " on disc" : "");
}

std::string travel_part(const RunStatus& s) {
  return s.travel_m ? fmt::format("x {} mm", format_fixed(*s.travel_m * 1e3, 3)) : std::string();
}

std::optional<double> fraction(const RunStatus& s) {
  const double all_s = s.elapsed_s + s.left_s;
  if (!(s.planned_s > 0) || !(all_s > 0)) return std::nullopt;
  return std::clamp(s.elapsed_s / all_s, 0.0, 1.0);
}

// "left >0:23" while the current step takes longer than planned, because nobody knows how long.
std::string left_part(const RunStatus& s) {
  if (!(s.planned_s > 0)) return "";
  if (s.overdue && s.left_s < 0.5) return "overdue";  // nothing is planned after this step
  return fmt::format("left {}{}", s.overdue ? ">" : "", format_time(s.left_s));
}

std::string percent_part(const RunStatus& s) {
  const auto done = fraction(s);
  return done ? fmt::format("{:.0f}%", std::floor(*done * 100)) : std::string();
}

std::string bar(double done, int columns) {
  const int inner = columns - 2;
  const int full = static_cast<int>(std::floor(done * inner));
  return "[" + std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(inner - full), '.') + "]";
}

std::string join(const std::vector<std::string>& parts) {
  std::string out;
  for (const auto& part : parts) {
    if (part.empty()) continue;
    if (!out.empty()) out += "  ";
    out += part;
  }
  return out;
}

}  // namespace

std::string format_fixed(double value, int digits) {
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.starts_with('-') && text.find_first_not_of("-0.") == text.npos) text.erase(0, 1);
  return text;
}

std::string format_time(double seconds) {
  const auto all = static_cast<std::int64_t>(std::llround(std::max(0.0, seconds)));
  const auto h = all / 3600;
  const auto m = all / 60 % 60;
  const auto s = all % 60;
  if (h > 0) return fmt::format("{}:{:02}:{:02}", h, m, s);
  return fmt::format("{}:{:02}", m, s);
}

std::string unproven_words(std::int64_t readings) {
  return readings == 0 ? "" : fmt::format(", {} more are not proven", readings);
}

std::string format_live_line(const RunStatus& s, int width) {
  const auto room = static_cast<std::size_t>(std::max(1, width - 1));
  enum { kStep, kRepeat, kCapacitance, kForce, kPressure, kTravel, kBar, kPercent, kLeft };
  std::vector<std::string> parts{place_part(s),
                                 repeat_part(s),
                                 capacitance_part(s),
                                 force_part(s),
                                 pressure_part(s),
                                 travel_part(s),
                                 "",
                                 percent_part(s),
                                 left_part(s)};
  bool whole = true;
  for (const int victim : {kPercent, kRepeat, kPressure, kTravel, kLeft, kForce}) {
    if (join(parts).size() <= room) break;
    parts[static_cast<std::size_t>(victim)].clear();
    whole = false;
  }
  // The bar takes only room that is left over; it never displaces a number.
  const auto used = join(parts).size();
  if (const auto done = fraction(s); whole && done && used + 2 + kBarMin <= room) {
    const auto columns = std::min(static_cast<int>(room - used) - 2, kBarMax);
    parts[kBar] = bar(*done, columns);
  }
  return join(parts).substr(0, room);
}

std::string format_plain_line(const RunStatus& s) {
  return join({format_time(s.elapsed_s), place_part(s), repeat_part(s), capacitance_part(s),
               force_part(s), pressure_part(s), travel_part(s), percent_part(s), left_part(s)});
}

bool LiveLine::due(const RunStatus& s) {
  const bool news = !last_ || s.step_id != last_step_ || s.repeat != last_repeat_ ||
                    s.state != last_state_ || s.standstill != last_standstill_ ||
                    s.prompt != last_prompt_;
  const MonoTime now = clock_.now();
  const auto pause = console_.err_tty ? std::chrono::milliseconds(50) : std::chrono::seconds(1);
  // A rehearsal passes steps faster than anybody can read, so on a terminal only time counts.
  const bool wanted = console_.err_tty ? !last_ || s.state != last_state_ : news;
  if (!wanted && now - *last_ < pause) return false;
  last_ = now;
  last_step_ = s.step_id;
  last_repeat_ = s.repeat;
  last_state_ = s.state;
  last_standstill_ = s.standstill;
  return true;
}

void LiveLine::show_prompt(const RunStatus& s) {
  if (s.prompt == last_prompt_) return;
  last_prompt_ = s.prompt;
  if (s.prompt.empty()) return;
  const auto asked = ascii(s.prompt, kLongestWords);
  if (s.question && s.question->question.type != AnswerType::confirmation) {
    const char* how =
        console_.in_tty ? "type the answer and press Enter" : "type: lcrig answer VALUE";
    return say(fmt::format("{}  ({})", asked, how));
  }
  const char* how = console_.in_tty ? "press Enter" : "type: lcrig confirm";
  say(fmt::format("{}  ({} when done)", asked, how));
}

void LiveLine::show(const RunStatus& s) {
  const bool now = due(s);
  show_prompt(s);
  if (!now) return;
  if (!console_.err_tty) {
    fmt::print(console_.err, "{}\n", format_plain_line(s));
    console_.err.flush();
    return;
  }
  drawn_ = format_live_line(s, console_.width ? console_.width() : 80);
  fmt::print(console_.err, "\r{}\x1b[K", drawn_);
  console_.err.flush();
}

void LiveLine::say_one_line(const std::string& text) {
  const auto room = static_cast<std::size_t>(std::max(4, console_.width ? console_.width() : 80));
  const bool cut = console_.err_tty && text.size() >= room;
  say(cut ? text.substr(0, room - 4) + "..." : text);
}

void LiveLine::say(const std::string& text) {
  if (console_.err_tty && !drawn_.empty()) {
    fmt::print(console_.err, "\r\x1b[K{}\n{}", text, drawn_);
  } else {
    fmt::print(console_.err, "{}\n", text);
  }
  console_.err.flush();
}

void LiveLine::finish() {
  if (console_.err_tty && !drawn_.empty()) fmt::print(console_.err, "\r\x1b[K");
  drawn_.clear();
  console_.err.flush();
}

}  // namespace lcrig::cli
