// SPDX-License-Identifier: Apache-2.0
// The commands of the back door.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/number.hpp"
#include "tools/lcrig-sim/back_door.hpp"

namespace lcrig::sim {

using nlohmann::json;

namespace {

using Words = std::vector<std::string_view>;
using Kind = lcr6100::SimFaults::Kind;

Words split(std::string_view line) {
  Words words;
  while (!line.empty()) {
    const auto end = std::min(line.find_first_of(" \t\r"), line.size());
    if (end > 0) words.push_back(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return words;
}

Result<double> number(const Words& words, std::size_t i) {
  if (i >= words.size()) return fail(Errc::invalid_request, "{}: a number is missing", words[0]);
  const auto value = number_from<double>(words[i]);
  if (value && *value >= 0 && *value < 1e6) return *value;
  return fail(Errc::invalid_request, "{}: expected a number from 0 on", words[i]);
}

Result<lcr6100::SimFaults*> meter_faults(Bench& b) {
  if (b.meter.meter() == nullptr) {
    return fail(Errc::invalid_request, "the meter is unplugged: `plug lcr`");
  }
  return &b.meter.meter()->faults();
}

Result<ZwickSim*> gateway(Bench& b) {
  if (b.frame == nullptr) return fail(Errc::invalid_request, "this bench has a rod and no frame");
  if (b.frame->gateway() == nullptr) {
    return fail(Errc::invalid_request, "nobody is connected to the frame");
  }
  return b.frame->gateway();
}

Result<> next_answer(Bench& b, Kind kind, Duration delay = {}) {
  auto faults = meter_faults(b);
  if (!faults) return fail(faults.error());
  (*faults)->replies.emplace_back(kind, delay);
  return {};
}

Result<> late_answer(Bench& b, const Words& words) {
  const auto seconds = number(words, 2);
  if (!seconds) return fail(seconds.error());
  return next_answer(b, Kind::none, from_seconds(*seconds));
}

Result<> set_meter(Bench& b, bool lcr6100::SimFaults::* fault) {
  auto faults = meter_faults(b);
  if (!faults) return fail(faults.error());
  (*faults)->*fault = true;
  return {};
}

Result<> set_frame(Bench& b, bool ZwickSimFaults::* fault) {
  auto frame = gateway(b);
  if (!frame) return fail(frame.error());
  (*frame)->faults.*fault = true;
  (*frame)->poke();
  return {};
}

Result<> stall(Bench& b) {
  auto frame = gateway(b);
  if (!frame) return fail(frame.error());
  (*frame)->stall();
  return {};
}

Result<> heal(Bench& b) {
  b.meter.heal();
  if (b.frame != nullptr) b.frame->heal();
  return {};
}

Result<> unplug_frame(Bench& b) {
  if (b.frame == nullptr) return fail(Errc::invalid_request, "this bench has a rod and no frame");
  b.frame->unplug();
  return {};
}

Result<> plug_frame(Bench& b) {
  if (b.frame == nullptr) return fail(Errc::invalid_request, "this bench has a rod and no frame");
  return b.frame->plug();
}

Result<> load(Bench& b, const Words& words) {
  const auto force_N = number(words, 1);
  if (!force_N) return fail(force_N.error());
  if (b.frame != nullptr) return fail(Errc::invalid_request, "load: only with --weights");
  b.plant.put_load(b.clock.now(), *force_N);
  return {};
}

struct Word {
  std::string_view verb, target;  // empty target: the command has none
  Result<> (*act)(Bench&, const Words&);
};

constexpr std::array<Word, 17> kWords{{
    {"status", "", [](Bench&, const Words&) { return Result<>(); }},
    // BackDoor delays the answer until the drive stands, for at most 10 s.
    {"settle", "", [](Bench&, const Words&) { return Result<>(); }},
    {"heal", "", [](Bench& b, const Words&) { return heal(b); }},
    {"load", "", load},
    {"unplug", "lcr", [](Bench& b, const Words&) { return b.meter.unplug(), Result<>(); }},
    {"plug", "lcr", [](Bench& b, const Words&) { return b.meter.plug(); }},
    {"silent", "lcr",
     [](Bench& b, const Words&) { return set_meter(b, &lcr6100::SimFaults::silent); }},
    {"overload", "lcr",
     [](Bench& b, const Words&) { return set_meter(b, &lcr6100::SimFaults::overload); }},
    {"late", "lcr", late_answer},
    {"drop", "lcr", [](Bench& b, const Words&) { return next_answer(b, Kind::drop); }},
    {"cut", "lcr", [](Bench& b, const Words&) { return next_answer(b, Kind::cut); }},
    {"garble", "lcr", [](Bench& b, const Words&) { return next_answer(b, Kind::garble); }},
    {"unplug", "frame", [](Bench& b, const Words&) { return unplug_frame(b); }},
    {"plug", "frame", [](Bench& b, const Words&) { return plug_frame(b); }},
    {"silent", "frame",
     [](Bench& b, const Words&) { return set_frame(b, &ZwickSimFaults::silent); }},
    {"deaf", "frame", [](Bench& b, const Words&) { return set_frame(b, &ZwickSimFaults::deaf); }},
    {"stall", "frame", [](Bench& b, const Words&) { return stall(b); }},
}};

std::string known_words() {
  std::string out;
  for (const Word& w : kWords) {
    out += fmt::format("{}{}{}{}", out.empty() ? "" : ", ", w.verb, w.target.empty() ? "" : " ",
                       w.target);
  }
  return out;
}

json state_of(Bench& b) {
  const MonoTime now = b.clock.now();
  json out{{"lcr", nullptr}, {"frame", nullptr}};
  if (b.meter.is_plugged()) out["lcr"] = b.meter.url();
  if (b.frame != nullptr) {
    ZwickSim* const gateway = b.frame->gateway();
    out["frame"] = b.frame->url();
    out["connected"] = gateway != nullptr;
    out["moving"] = is_moving(b);
    out["travel_mm"] = b.plant.travel_m(now) * 1e3;
  }
  out["force_N"] = b.plant.force_N(now);
  return out;
}

}  // namespace

bool is_moving(const Bench& bench) {
  const auto arrival = bench.plant.arrival();
  return arrival && *arrival > bench.clock.now();
}

Result<json> obey(Bench& bench, std::string_view line) {
  const Words words = split(line);
  const std::string_view verb = words.empty() ? "" : words[0];
  const auto fits = [&](const Word& w) {
    return w.verb == verb && (w.target.empty() || (words.size() > 1 && words[1] == w.target));
  };
  const auto* const word = std::ranges::find_if(kWords, fits);
  if (word == kWords.end()) {
    return fail(Errc::invalid_request, "unknown command; known: {}", known_words());
  }
  if (auto done = word->act(bench, words); !done) return fail(done.error());
  return state_of(bench);
}

}  // namespace lcrig::sim
