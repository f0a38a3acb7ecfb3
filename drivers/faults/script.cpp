// SPDX-License-Identifier: Apache-2.0
#include "drivers/faults/script.hpp"

#include <fmt/format.h>
#include <iterator>
#include <utility>

#include "base/near_word.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "drivers/lcr6100/sim.hpp"

namespace lcrig {

namespace {

using namespace fault_parameter;
using S = FaultShape;
using T = FaultTarget;

constexpr double kLongest_s = 1e7;  // upper limit of every time, about four months
constexpr Range kAnyTime{0, kLongest_s};
constexpr Range kSomeTime{0, kLongest_s, true};
constexpr Range kTimeChange{-1e9, 1e9};
constexpr Range kProbability{0, 1, true};
constexpr std::int64_t kMostTimes = 1'000'000'000;

// The parameters that are numbers. Files and messages use the same name.
struct NumberParameter {
  unsigned bit;
  const char* key;
  double Fault::* member;
  Range range;
};
constexpr NumberParameter kNumbers[] = {
    {kDelay, "delay_s", &Fault::delay_s, {0, 3600, true}},
    {kFactor, "factor", &Fault::factor, {1, 1e4}},
    {kGain, "factor", &Fault::factor, {0, 1e4}},  // a cell may show less, a clock be slow
    {kBytes, "byte_probability", &Fault::byte_probability, kProbability},
    {kJump, "jump_s", &Fault::jump_s, kTimeChange},
    {kStep, "step_s", &Fault::step_s, kTimeChange},
    {kForce, "force_N", &Fault::force_N, {-1e6, 1e6}},
    {kRate, "rate_N_s", &Fault::rate_N_s, {-1e3, 1e3}},
    {kSpeed, "speed_um_s", &Fault::speed_um_s, {-1e5, 1e5}},
};
struct FlagParameter {
  unsigned bit;
  const char* key;
  bool Fault::* member;
};
constexpr FlagParameter kFlags[] = {{kOtherPort, "other_port", &Fault::other_port},
                                    {kForgets, "forgets_zero", &Fault::forgets_zero},
                                    {kOrigin, "origin_changes", &Fault::origin_changes}};

const FaultKind* find_kind(const JsonReader& r, FaultTarget on, std::string_view name) {
  std::vector<std::string> known;
  for (const FaultKind& kind : fault_kinds()) {
    if (kind.on != on) continue;
    if (kind.name == name) return &kind;
    known.emplace_back(kind.name);
  }
  if (r.sound()) {
    r.at("fault").refuse(fmt::format("no fault `{}` there{}; expected one of {}", name,
                                     did_you_mean(name, known), fmt::join(known, ", ")));
  }
  return nullptr;
}

void read_parameters(const JsonReader& r, Fault& f) {
  const auto has = [&f](unsigned p) { return (f.kind->parameters & p) != 0; };
  for (const NumberParameter& p : kNumbers) {
    if (has(p.bit)) f.*p.member = r.number(p.key, p.range);
  }
  if (has(kSamples)) f.samples = r.optional_integer("samples", 1, kMostTimes).value_or(1);
  if (has(kText)) f.text = r.optional_string("text").value_or("");
  if (has(kIdentity)) f.identity = r.at("identity").nonempty_string();
  if (has(kCode) && r.has("code")) f.code = r.at("code").nonempty_string(40);
  for (const FlagParameter& p : kFlags) {
    if (has(p.bit)) f.*p.member = r.optional_boolean(p.key).value_or(false);
  }
  if (!has(kPanel)) return;
  f.setting = r.word<PanelKey>("setting");
  f.to = r.at("to").nonempty_string(40);
  if (r.sound() && !lcr6100::Lcr6100Sim::accepts(f.setting, f.to)) {
    r.at("to").refuse(fmt::format("\"{}\", which is no {} of the simulated meter; it has {}",
                                  printable(f.to), to_string(f.setting),
                                  lcr6100::Lcr6100Sim::accepted_words(f.setting)));
  }
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
  // A start without a count or duration means one event: the next from then on.
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
  const auto on = r.word<FaultTarget>("on");
  const std::string name = r.string("fault");
  if (r.has("comment")) r.string("comment");
  f.kind = find_kind(r, on, name);
  if (f.kind == nullptr) return f;
  read_window(r, f);
  if (f.is(S::counted)) {
    read_rate(r, f);
  } else {
    read_repetition(r, f);
  }
  if (f.is(S::once) && f.for_s) r.at("for_s").refuse("this fault happens at once; leave it out");
  const bool needs_end = (f.kind->parameters & kNeedsEnd) != 0;
  if (needs_end && !f.for_s)
    r.refuse("for_s is missing: a person comes back some time, a restart ends");
  read_parameters(r, f);
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
    if (f.kind->on == T::frame && !stage.has_frame) {
      return fail(Errc::invalid_request, "{}: {}: there are weights on a rod and no frame", f.where,
                  f.kind->name);
    }
    if (f.in_step && !stage.knows_steps) {
      return fail(Errc::invalid_request,
                  "{}/in_step: the simulated bench does not know the steps of a run; give at_s, or "
                  "use `lcrig rehearse --faults`",
                  f.where);
    }
    if (f.kind->on == T::bench && !stage.has_surroundings) {
      return fail(Errc::invalid_request,
                  "{}: {}: disk, memory, clock and operator are not the simulated bench's; use "
                  "`lcrig rehearse --faults`",
                  f.where, f.kind->name);
    }
  }
  return {};
}

std::string describe(const Fault& f) {
  const auto has = [&](unsigned p) { return (f.kind->parameters & p) != 0; };
  std::string out = fmt::format("{} {}", to_string(f.kind->on), f.kind->name);
  const auto add = [&out](std::string_view key, const auto& value) {
    fmt::format_to(std::back_inserter(out), ", {} {}", key, value);
  };
  for (const NumberParameter& p : kNumbers) {
    if (has(p.bit)) add(p.key, f.*p.member);
  }
  if (has(kSamples)) add("samples", f.samples);
  if (has(kText) && !f.text.empty()) add("text", f.text);
  if (has(kIdentity)) add("identity", f.identity);
  if (has(kCode)) add("code", f.code);
  if (has(kPanel)) add(to_string(f.setting), f.to);
  for (const FlagParameter& p : kFlags) {
    if (f.*p.member) out += fmt::format(", {}", p.key);
  }
  return out;
}

}  // namespace lcrig
