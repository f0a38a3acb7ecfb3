// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/codec.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

#include "base/decimal.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "drivers/zwick/millimetres.hpp"

namespace lcrig::frame_link {

namespace {

constexpr std::array<std::pair<MotionEnd, std::string_view>, 5> kReasons{{
    {MotionEnd::target, "target"},
    {MotionEnd::force_limit, "force_limit"},
    {MotionEnd::travel_limit, "travel_limit"},
    {MotionEnd::stopped, "stop"},
    {MotionEnd::fault, "fault"},
}};

void add_hello(Writer& w, const Hello& hello) {
  w.integer("proto", hello.protocol);
  if (hello.revision > 1) w.integer("revision", hello.revision);
  w.text("side", hello.side);
  w.text("maker", hello.identity.maker).text("model", hello.identity.model);
  w.text("serial", hello.identity.serial).text("version", hello.identity.firmware);
  if (!hello.origin.empty()) w.text("origin", hello.origin);
  if (hello.identity.simulated) w.flag("simulated", true);
}

// All six fields must be present or none: some of them without the others bound nothing.
Result<std::optional<ForceLoop>> parse_force_loop(const Line& line) {
  constexpr std::array<std::string_view, 6> kKeys{
      "force_approach_mm_s", "force_contact_N", "force_rate_max_N_s",
      "force_lag_s",         "force_ripple_N",  "force_stiffness_max_N_mm"};
  const auto given = [&](std::string_view key) { return line.find(key).has_value(); };
  if (std::ranges::none_of(kKeys, given)) return std::optional<ForceLoop>();
  std::array<double, 6> v{};
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    const auto value = line.number_of(kKeys[i]);
    if (!value) return fail(value.error());
    if (*value < 0) return fail(Errc::garbled, "CAPS with a negative {}", kKeys[i]);
    v[i] = *value;
  }
  if (v[3] > 60) return fail(Errc::garbled, "CAPS with a force loop that lags for {:.6g} s", v[3]);
  ForceLoop loop;
  loop.approach = Velocity::from_si(from_mm(v[0]));
  loop.contact = Force::from_si(v[1]);
  loop.rate_max = ForceRate::from_si(v[2]);
  loop.lag = from_seconds(v[3]);
  loop.ripple = Force::from_si(v[4]);
  loop.stiffness_max = Stiffness::from_si(shift_decimal(v[5], 3));
  return std::optional<ForceLoop>(loop);
}

Result<std::optional<ForceClass>> parse_force_class(const Line& line) {
  if (!line.find("force_class")) return std::optional<ForceClass>();
  const auto percent = line.number_of("force_class");
  if (!percent) return fail(percent.error());
  if (!is_force_class(*percent)) {
    return fail(Errc::garbled, "CAPS with a force_class of {:.6g}, expected {}", *percent,
                kForceClassWords);
  }
  return std::optional(ForceClass(*percent));
}

// An optional field of revision 3; `digits` shifts its unit to SI.
template <class T>
Result<> parse_stated(const Line& line, std::string_view key, int digits, T (*make)(double),
                      std::optional<T>& out) {
  constexpr double kMost = 60;  // of a time, as for reaction_s
  if (!line.find(key)) return {};
  const auto value = line.number_of(key);
  if (!value) return fail(value.error());
  if (*value < 0 || (std::is_same_v<T, Duration> && *value > kMost)) {
    return fail(Errc::garbled, "CAPS with a {} of {:.6g}", key, *value);
  }
  out = make(shift_decimal(*value, digits));
  return {};
}

Result<> parse_all_stated(const Line& line, FrameCapabilities& c) {
  auto r = parse_stated<Length>(line, "travel_step_um", -6, Length::from_si, c.travel_step);
  if (r) r = parse_stated<Force>(line, "force_step_mN", -3, Force::from_si, c.force_step);
  if (r) r = parse_stated<Duration>(line, "filter_s", 0, from_seconds, c.filter);
  if (r) r = parse_stated<Length>(line, "play_um", -6, Length::from_si, c.play);
  return r;
}

}  // namespace

std::string format_hello(const Hello& hello) {
  Writer w("HELLO");
  add_hello(w, hello);
  return w.line();
}

std::string format_observe(const Hello& hello, double rate_Hz) {
  Writer w("OBSERVE");
  add_hello(w, hello);
  return w.number("hz", rate_Hz).line();
}

Result<Hello> parse_hello(const Line& line) {
  const auto protocol = number_from<std::int64_t>(line.find("proto").value_or(std::string_view()));
  const auto revision = number_from<std::int64_t>(line.find("revision").value_or("1"));
  if (!protocol || *protocol < 1 || *protocol > 1'000'000) {
    return fail(Errc::garbled, "HELLO lacks a protocol number (proto=1)");
  }
  if (!revision || *revision < 1 || *revision > 1'000'000) {
    return fail(Errc::garbled, "HELLO with a revision that is no number from 1 on");
  }
  Hello hello;
  hello.protocol = static_cast<int>(*protocol);
  hello.revision = static_cast<int>(*revision);
  hello.origin = line.text("origin");
  hello.identity.simulated = line.flag("simulated");
  hello.side = line.text("side");
  hello.identity.maker = line.text("maker");
  hello.identity.model = line.text("model");
  hello.identity.serial = line.text("serial");
  hello.identity.firmware = line.text("version");
  return hello;
}

std::string format_caps(const FrameCapabilities& c) {
  Writer w("CAPS");
  w.flag("motion", c.motion).flag("force_hold", c.force_hold).flag("device_stop", c.device_stop);
  w.flag("force", c.force_channel).flag("travel", c.travel_channel);
  w.flag("zero_force", c.zero_force).flag("zero_travel", c.zero_travel);
  w.number("force_max_N", c.force_max.si());
  if (c.force_class) w.number("force_class", c.force_class->percent());
  w.number("speed_min_mm_s", to_mm(c.speed_min.si()));
  w.number("speed_max_mm_s", to_mm(c.speed_max.si()));
  w.number("travel_min_mm", to_mm(c.travel_min.si()));
  w.number("travel_max_mm", to_mm(c.travel_max.si()));
  w.number("rate_max_hz", c.sample_rate_max_Hz);
  w.number("reaction_s", to_seconds(c.reaction));
  w.number("deceleration_mm_s2", to_mm(c.deceleration.si()));
  if (c.travel_step) w.number("travel_step_um", shift_decimal(c.travel_step->si(), 6));
  if (c.force_step) w.number("force_step_mN", shift_decimal(c.force_step->si(), 3));
  if (c.filter) w.number("filter_s", to_seconds(*c.filter));
  if (c.play) w.number("play_um", shift_decimal(c.play->si(), 6));
  if (const auto& loop = c.force_loop) {
    w.number("force_approach_mm_s", to_mm(loop->approach.si()));
    w.number("force_contact_N", loop->contact.si());
    w.number("force_rate_max_N_s", loop->rate_max.si());
    w.number("force_lag_s", to_seconds(loop->lag)).number("force_ripple_N", loop->ripple.si());
    w.number("force_stiffness_max_N_mm", shift_decimal(loop->stiffness_max.si(), -3));
  }
  return w.line();
}

Result<FrameCapabilities> parse_caps(const Line& line) {
  constexpr std::array<std::string_view, 8> kKeys{
      "force_max_N",   "speed_min_mm_s", "speed_max_mm_s", "travel_min_mm",
      "travel_max_mm", "rate_max_hz",    "reaction_s",     "deceleration_mm_s2"};
  std::array<double, 8> v{};
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    const auto value = line.number_of(kKeys[i]);
    if (!value) return fail(value.error());
    v[i] = *value;
  }
  if (v[0] < 0 || v[1] < 0 || v[2] < v[1] || v[4] < v[3] || v[5] <= 0 || v[6] < 0 || v[6] > 60 ||
      v[7] <= 0) {
    return fail(Errc::garbled, "CAPS with a range that is empty or negative");
  }
  FrameCapabilities c;
  c.motion = line.flag("motion");
  c.force_hold = line.flag("force_hold");
  c.device_stop = line.flag("device_stop");
  c.force_channel = line.flag("force");
  c.travel_channel = line.flag("travel");
  c.zero_force = line.flag("zero_force");
  c.zero_travel = line.flag("zero_travel");
  c.force_max = Force::from_si(v[0]);
  if (auto r = keep(parse_force_class(line), c.force_class); !r) return fail(r.error());
  c.speed_min = Velocity::from_si(from_mm(v[1]));
  c.speed_max = Velocity::from_si(from_mm(v[2]));
  c.travel_min = Length::from_si(from_mm(v[3]));
  c.travel_max = Length::from_si(from_mm(v[4]));
  c.sample_rate_max_Hz = v[5];
  c.reaction = from_seconds(v[6]);
  c.deceleration = Acceleration::from_si(from_mm(v[7]));
  if (auto r = parse_all_stated(line, c); !r) return fail(r.error());
  if (c.force_hold) {
    if (auto r = keep(parse_force_loop(line), c.force_loop); !r) return fail(r.error());
  }
  return c;
}

std::string format_limits(std::int64_t number, const FrameLimits& l) {
  Writer w(number, "LIMITS");
  w.number("force_min_N", l.force_min.si()).number("force_max_N", l.force_max.si());
  w.number("travel_min_mm", to_mm(l.travel_min.si()));
  w.number("travel_max_mm", to_mm(l.travel_max.si()));
  return w.number("speed_max_mm_s", to_mm(l.speed_max.si())).line();
}

Result<FrameLimits> parse_limits(const Line& line) {
  constexpr std::array<std::string_view, 5> kKeys{"force_min_N", "force_max_N", "travel_min_mm",
                                                  "travel_max_mm", "speed_max_mm_s"};
  std::array<double, 5> v{};
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    const auto value = line.number_of(kKeys[i]);
    if (!value) return fail(value.error());
    v[i] = *value;
  }
  FrameLimits l;
  l.force_min = Force::from_si(v[0]);
  l.force_max = Force::from_si(v[1]);
  l.travel_min = Length::from_si(from_mm(v[2]));
  l.travel_max = Length::from_si(from_mm(v[3]));
  l.speed_max = Velocity::from_si(from_mm(v[4]));
  return l;
}

std::string format_move(std::int64_t number, Length travel, Velocity speed) {
  Writer w(number, "MOVE");
  return w.number("travel_mm", to_mm(travel.si())).number("speed_mm_s", to_mm(speed.si())).line();
}
std::string format_move_until(std::int64_t number, Force force, Velocity speed, Length guard) {
  Writer w(number, "MOVEF");
  w.number("force_N", force.si()).number("speed_mm_s", to_mm(speed.si()));
  return w.number("guard_mm", to_mm(guard.si())).line();
}
std::string format_ramp(std::int64_t number, Force force, ForceRate rate) {
  return Writer(number, "RAMPF").number("force_N", force.si()).number("rate_N_s", rate.si()).line();
}
std::string format_hold_travel(std::int64_t number) {
  Writer w(number, "HOLD mode=travel");
  return w.line();
}
std::string format_hold_force(std::int64_t number, Force force) {
  return Writer(number, "HOLD mode=force").number("force_N", force.si()).line();
}
std::string format_zero(std::int64_t number, bool force, bool travel) {
  return Writer(number, "ZERO").flag("force", force).flag("travel", travel).line();
}
std::string format_rate(std::int64_t number, double rate_Hz) {
  return Writer(number, "RATE").number("hz", rate_Hz).line();
}
std::string format_status(std::int64_t number) {
  return Writer(number, "STATUS").line();
}

Result<Length> length_of(const Line& line, std::string_view key) {
  auto mm = line.number_of(key);
  if (!mm) return fail(mm.error());
  return Length::from_si(from_mm(*mm));
}
Result<Velocity> speed_of(const Line& line) {
  auto mm_s = line.number_of("speed_mm_s");
  if (!mm_s) return fail(mm_s.error());
  return Velocity::from_si(from_mm(*mm_s));
}
Result<Force> force_of(const Line& line) {
  auto newton = line.number_of("force_N");
  if (!newton) return fail(newton.error());
  return Force::from_si(*newton);
}

std::string format_ok(std::int64_t number) {
  return Writer("OK", number).line();
}
std::string format_ok(std::int64_t number, std::string_view origin) {
  return Writer("OK", number).text("origin", origin).line();
}
std::string format_err(std::int64_t number, std::string_view code, std::string_view text) {
  return Writer("ERR", number).text("code", code).text("text", text).line();
}
std::string format_done(std::int64_t number, const MotionOutcome& o) {
  Writer w("DONE", number);
  const auto reason = std::ranges::find(kReasons, o.reason, [](const auto& r) { return r.first; });
  w.text("reason", reason->second).number("force_N", o.force_N);
  return w.number("travel_mm", to_mm(o.travel_m)).text("text", o.detail).line();
}
std::string format_stopped(std::int64_t stops, const MotionOutcome& o) {
  Writer w("STOPPED");
  w.integer("stops", stops).number("force_N", o.force_N);
  return w.number("travel_mm", to_mm(o.travel_m)).line();
}
std::string format_event(std::string_view kind, std::string_view text) {
  return Writer("EVENT").text("kind", kind).text("text", text).line();
}
std::string format_heartbeat(double device_time_s) {
  return Writer("HB").number("t_s", device_time_s).line();
}

MotionOutcome parse_done(const Line& line) {
  MotionOutcome o;
  const auto word = line.text("reason");
  const auto reason = std::ranges::find(kReasons, word, [](const auto& r) { return r.second; });
  o.detail = line.text("text");
  if (reason == kReasons.end()) {
    o.reason = MotionEnd::fault;
    o.detail = "unknown reason '" + printable(excerpt(word)) + "' " + o.detail;
  } else {
    o.reason = reason->first;
  }
  if (const auto force = line.number_of("force_N")) o.force_N = *force;
  if (const auto travel = line.number_of("travel_mm")) o.travel_m = from_mm(*travel);
  return o;
}

}  // namespace lcrig::frame_link
