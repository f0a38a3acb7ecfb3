// SPDX-License-Identifier: Apache-2.0
#include "drivers/faults/script.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "base/near_word.hpp"
#include "base/strict_json.hpp"

namespace lcrig {

namespace {

// Parameters, as bits.
enum Parameter : unsigned {
  kDelay = 1U << 0U,
  kFactor = 1U << 1U,
  kBytes = 1U << 2U,
  kJump = 1U << 3U,
  kForce = 1U << 4U,
  kSamples = 1U << 5U,
  kText = 1U << 6U,
  kIdentity = 1U << 7U,
  kCode = 1U << 8U,
  kOtherPort = 1U << 9U,
  kForgets = 1U << 10U,
  kStep = 1U << 11U,
  kNeedsEnd = 1U << 12U,  // not a parameter: for_s is required
  kRate = 1U << 13U,
  kSpeed = 1U << 14U,
  kOrigin = 1U << 15U,
};

struct Spec {
  FaultTarget on;
  std::string_view name;
  FaultKind kind;
  FaultShape shape;
  unsigned parameters = 0;
};

using K = FaultKind;
using T = FaultTarget;
using S = FaultShape;

constexpr std::array kSpecs{
    Spec{T::meter, "reply_late", K::reply_late, S::counted, kDelay},
    Spec{T::meter, "reply_lost", K::reply_lost, S::counted},
    Spec{T::meter, "reply_cut", K::reply_cut, S::counted},
    Spec{T::meter, "reply_doubled", K::reply_doubled, S::counted},
    Spec{T::meter, "reply_garbled", K::reply_garbled, S::counted},
    Spec{T::meter, "reply_echoed", K::reply_echoed, S::counted},
    Spec{T::meter, "set_lost", K::set_lost, S::counted},
    Spec{T::meter, "unsolicited", K::unsolicited, S::once, kText},
    Spec{T::meter, "stuck", K::stuck, S::lasting},
    Spec{T::meter, "overload", K::overload, S::lasting},
    Spec{T::meter, "slow", K::slow, S::lasting, kFactor},
    Spec{T::meter, "line_noise", K::meter_noise, S::lasting, kBytes},
    Spec{T::meter, "silent", K::meter_silent, S::lasting},
    Spec{T::meter, "unplug", K::meter_unplug, S::lasting, kOtherPort},
    Spec{T::meter, "power_cycle", K::meter_power_cycle, S::lasting},
    Spec{T::meter, "other_instrument", K::other_instrument, S::lasting, kIdentity},
    Spec{T::frame, "line_late", K::line_late, S::counted, kDelay},
    Spec{T::frame, "line_lost", K::line_lost, S::counted},
    Spec{T::frame, "line_cut", K::line_cut, S::counted},
    Spec{T::frame, "line_doubled", K::line_doubled, S::counted},
    Spec{T::frame, "line_garbled", K::line_garbled, S::counted},
    Spec{T::frame, "refusal", K::refusal, S::counted, kCode},
    Spec{T::frame, "completion_lost", K::completion_lost, S::counted},
    Spec{T::frame, "samples_lost", K::samples_lost, S::once, kSamples},
    Spec{T::frame, "clock_jump", K::clock_jump, S::once, kJump},
    Spec{T::frame, "force_spike", K::force_spike, S::once, kForce | kSamples},
    Spec{T::frame, "stall", K::stall, S::once},
    Spec{T::frame, "overshoot", K::overshoot, S::lasting, kDelay},
    Spec{T::frame, "heartbeat_lost", K::heartbeat_lost, S::lasting},
    Spec{T::frame, "gateway_restarted", K::gateway_restarted, S::once, kForgets},
    Spec{T::frame, "line_noise", K::frame_noise, S::lasting, kBytes},
    Spec{T::frame, "silent", K::frame_silent, S::lasting},
    Spec{T::frame, "deaf", K::deaf, S::lasting},
    Spec{T::frame, "unplug", K::frame_unplug, S::lasting, kOtherPort},
    Spec{T::frame, "power_cycle", K::frame_power_cycle, S::lasting},
    Spec{T::frame, "force_frozen", K::force_frozen, S::lasting},
    Spec{T::frame, "force_held", K::force_held, S::lasting},
    Spec{T::frame, "force_gain", K::force_gain, S::lasting, kFactor},
    Spec{T::frame, "force_reversed", K::force_reversed, S::lasting},
    Spec{T::frame, "force_drift", K::force_drift, S::lasting, kRate},
    Spec{T::frame, "force_scatter", K::force_scatter, S::lasting, kFactor},
    Spec{T::frame, "drive_reversed", K::drive_reversed, S::lasting},
    Spec{T::frame, "creep", K::creep, S::lasting, kSpeed},
    Spec{T::frame, "done_early", K::done_early, S::lasting},
    Spec{T::frame, "done_unmoved", K::done_unmoved, S::lasting},
    Spec{T::frame, "done_late", K::done_late, S::lasting, kDelay},
    Spec{T::frame, "order_late", K::order_late, S::lasting, kDelay},
    Spec{T::frame, "clock_frozen", K::clock_frozen, S::lasting},
    Spec{T::frame, "clock_rate", K::clock_rate, S::lasting, kFactor},
    Spec{T::frame, "tare_lost", K::tare_lost, S::once, kOrigin},
    Spec{T::frame, "estop", K::estop, S::lasting},
    Spec{T::frame, "stop_late", K::stop_late, S::lasting, kDelay},
    Spec{T::frame, "stop_unconfirmed", K::stop_unconfirmed, S::lasting},
    Spec{T::frame, "stop_ignored", K::stop_ignored, S::lasting},
    Spec{T::frame, "caps_changed", K::caps_changed, S::once},
    Spec{T::bench, "operator_absent", K::operator_absent, S::lasting, kNeedsEnd},
    Spec{T::bench, "disk_full", K::disk_full, S::lasting},
    Spec{T::bench, "disk_read_only", K::disk_read_only, S::lasting},
    Spec{T::bench, "disk_slow", K::disk_slow, S::lasting, kDelay},
    Spec{T::bench, "wall_clock_step", K::wall_clock_step, S::once, kStep},
    Spec{T::bench, "memory_short", K::memory_short, S::lasting},
};

constexpr std::array<std::pair<std::string_view, FaultTarget>, 3> kTargets{{
    {"meter", T::meter},
    {"frame", T::frame},
    {"bench", T::bench},
}};

constexpr double kLongest_s = 1e7;  // upper limit of every time, about four months
constexpr Range kAnyTime{0, kLongest_s};
constexpr Range kSomeTime{0, kLongest_s, true};
constexpr Range kTimeChange{-1e9, 1e9};
constexpr Range kProbability{0, 1, true};
constexpr std::int64_t kMostTimes = 1'000'000'000;

const Spec* find_spec(const JsonReader& r, FaultTarget on, std::string_view name) {
  std::vector<std::string> known;
  for (const Spec& s : kSpecs) {
    if (s.on != on) continue;
    if (s.name == name) return &s;
    known.emplace_back(s.name);
  }
  if (r.ok()) {
    r.at("fault").refuse(fmt::format("no fault `{}` there{}; expected one of {}", name,
                                     did_you_mean(name, known), fmt::join(known, ", ")));
  }
  return nullptr;
}

void read_parameters(const JsonReader& r, unsigned which, Fault& f) {
  const auto has = [which](Parameter p) { return (which & p) != 0; };
  if (has(kDelay)) f.delay_s = r.number("delay_s", Range{0, 3600, true});
  // A load cell may show less than the true force; the other factors only increase a value.
  const double least = f.kind == FaultKind::force_gain ? 0 : 1;
  if (has(kFactor)) f.factor = r.number("factor", Range{least, 1e4});
  if (has(kBytes)) f.byte_probability = r.number("byte_probability", kProbability);
  if (has(kJump)) f.jump_s = r.number("jump_s", kTimeChange);
  if (has(kStep)) f.step_s = r.number("step_s", kTimeChange);
  if (has(kForce)) f.force_N = r.number("force_N", Range{-1e6, 1e6});
  if (has(kRate)) f.rate_N_s = r.number("rate_N_s", Range{-1e3, 1e3});
  if (has(kSpeed)) f.speed_um_s = r.number("speed_um_s", Range{-1e5, 1e5});
  if (has(kSamples)) f.samples = r.optional_integer("samples", 1, kMostTimes).value_or(1);
  if (has(kText)) f.text = r.optional_string("text").value_or("");
  if (has(kIdentity)) f.identity = r.at("identity").nonempty_string();
  if (has(kCode) && r.has("code")) f.code = r.at("code").nonempty_string(40);
  if (has(kOtherPort)) f.other_port = r.optional_boolean("other_port").value_or(false);
  if (has(kForgets)) f.forgets_zero = r.optional_boolean("forgets_zero").value_or(false);
  if (has(kOrigin)) f.origin_changes = r.optional_boolean("origin_changes").value_or(false);
}

void read_window(const JsonReader& r, Fault& f) {
  f.at_s = r.optional_number("at_s", kAnyTime);
  if (r.has("in_step")) f.in_step = r.at("in_step").nonempty_string();
  if (f.at_s && f.in_step) r.refuse("has both at_s and in_step; give one of them");
  if (f.in_step) f.after_s = r.optional_number("after_s", kAnyTime).value_or(0);
  f.for_s = r.optional_number("for_s", kSomeTime);
  f.times = r.optional_integer("times", 1, kMostTimes);
}

void read_rate(const JsonReader& r, Fault& f) {
  f.every = r.optional_integer("every", 1, kMostTimes);
  f.probability = r.optional_number("probability", kProbability);
  if (f.every && f.probability) r.refuse("has both every and probability; give one of them");
  if (!f.has_window() && !f.every && !f.probability) {
    r.refuse("does not say when; give at_s, in_step, every or probability");
  }
  // A time without a count means the next event from then on.
  if (f.has_window() && !f.every && !f.probability && !f.for_s && !f.times) f.times = 1;
}

void read_repetition(const JsonReader& r, Fault& f) {
  if (!f.has_window()) r.refuse("does not say when; give at_s or in_step");
  if (f.at_s) f.every_s = r.optional_number("every_s", kSomeTime);
  if (f.every_s && f.for_s && *f.for_s >= *f.every_s) {
    r.refuse("lasts as long as it takes to come again; for_s must be below every_s");
  }
  if (!f.every_s && !f.times) f.times = 1;
}

Fault read_fault(const JsonReader& r) {
  Fault f;
  f.on = r.word<FaultTarget>("on", kTargets);
  f.name = r.string("fault");
  if (r.has("comment")) r.string("comment");
  const Spec* spec = find_spec(r, f.on, f.name);
  if (spec == nullptr) return f;
  f.kind = spec->kind;
  f.shape = spec->shape;
  read_window(r, f);
  if (f.shape == S::counted) {
    read_rate(r, f);
  } else {
    read_repetition(r, f);
  }
  if (f.shape == S::once && f.for_s)
    r.at("for_s").refuse("this fault happens at once; leave it out");
  const bool needs_end = (spec->parameters & kNeedsEnd) != 0;
  if (needs_end && !f.for_s) r.refuse("for_s is missing: a person comes back some time");
  read_parameters(r, spec->parameters, f);
  r.no_other_keys();
  return f;
}

}  // namespace

Result<FaultScript> parse_fault_script(std::string_view text, const std::string& name) {
  auto document = JsonDocument::parse(text, name);
  if (!document) return fail(document.error());
  const JsonReader root(*document);
  root.expect_format("faults/1");
  FaultScript script;
  script.text = std::string(text);
  script.name = root.optional_string("name").value_or(name);
  if (root.has("comment")) root.string("comment");
  constexpr std::int64_t kMaxSeed = 1'000'000'000'000;
  script.seed = static_cast<std::uint64_t>(root.optional_integer("seed", 0, kMaxSeed).value_or(1));
  for (const JsonReader& item : root.at("faults").items(1, 1000)) {
    Fault fault = read_fault(item);
    const TextPosition at = document->value_position(item.pointer());
    fault.where = fmt::format("{}:{}:{} {}", name, at.line, at.column, item.pointer());
    script.faults.push_back(std::move(fault));
  }
  root.no_other_keys();
  if (auto ok = root.result(); !ok) return fail(ok.error());
  return script;
}

Result<FaultScript> load_fault_script(const std::string& path) {
  auto text = read_text_file(path);
  if (!text) return fail(text.error());
  return parse_fault_script(*text, path);
}

Result<> check_stage(const FaultScript& script, const FaultStage& stage) {
  for (const Fault& f : script.faults) {
    if (f.on == T::frame && !stage.has_frame) {
      return fail(Errc::invalid_request, "{}: {}: there are weights on a rod and no frame", f.where,
                  f.name);
    }
    if (f.in_step && !stage.knows_steps) {
      return fail(Errc::invalid_request,
                  "{}/in_step: the simulated bench does not know the steps of a run; give at_s, or "
                  "use `lcrig rehearse --faults`",
                  f.where);
    }
    if (f.on == T::bench && !stage.has_surroundings) {
      return fail(Errc::invalid_request,
                  "{}: {}: disk, memory, clock and operator are not the simulated bench's; use "
                  "`lcrig rehearse --faults`",
                  f.where, f.name);
    }
  }
  return {};
}

std::string describe(const Fault& f) {
  const auto spec = std::ranges::find(kSpecs, f.kind, &Spec::kind);
  const auto has = [&](Parameter p) { return (spec->parameters & p) != 0; };
  const auto target =
      std::ranges::find(kTargets, f.on, &std::pair<std::string_view, FaultTarget>::second);
  std::string out = fmt::format("{} {}", target->first, f.name);
  const auto add = [&out](std::string_view key, const auto& value) {
    fmt::format_to(std::back_inserter(out), ", {} {}", key, value);
  };
  if (has(kDelay)) add("delay_s", f.delay_s);
  if (has(kFactor)) add("factor", f.factor);
  if (has(kBytes)) add("byte_probability", f.byte_probability);
  if (has(kJump)) add("jump_s", f.jump_s);
  if (has(kStep)) add("step_s", f.step_s);
  if (has(kForce)) add("force_N", f.force_N);
  if (has(kRate)) add("rate_N_s", f.rate_N_s);
  if (has(kSpeed)) add("speed_um_s", f.speed_um_s);
  if (has(kSamples)) add("samples", f.samples);
  if (has(kText) && !f.text.empty()) add("text", f.text);
  if (has(kIdentity)) add("identity", f.identity);
  if (has(kCode)) add("code", f.code);
  if (f.other_port) out += ", other_port";
  if (f.forgets_zero) out += ", forgets_zero";
  if (f.origin_changes) out += ", origin_changes";
  return out;
}

}  // namespace lcrig
