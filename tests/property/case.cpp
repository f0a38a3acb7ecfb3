// SPDX-License-Identifier: Apache-2.0
#include "tests/property/case.hpp"

#include <array>
#include <nlohmann/json.hpp>

namespace lcrig::property {

namespace {

using json = nlohmann::ordered_json;
using When = RigWorld::Act::When;

using What = Happening::Kind;
constexpr std::array<std::string_view, 11> kKinds{
    "abort",  "freeze",     "shutdown",    "pause",       "deaf",        "silent",
    "unplug", "after_step", "after_level", "after_cycle", "after_repeat"};
constexpr std::array<std::string_view, 5> kWhens{"time", "part", "step", "drive", "finally"};

void parse_instant(const json& j, Instant& at) {
  const std::string when = j.at("when");
  for (std::size_t i = 0; i < kWhens.size(); ++i) {
    if (when == kWhens[i]) at.when = static_cast<When>(i);
  }
  at.n = j.value("n", std::int64_t{0});
  at.after_s = j.at("after_s");
  at.lasts_s = j.value("lasts_s", 0.0);
}

Happening parse_happening(const json& j) {
  Happening h;
  const std::string what = j.at("what");
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    if (what == kKinds[i]) h.kind = static_cast<What>(i);
  }
  parse_instant(j, h);
  return h;
}

Falsehood parse_falsehood(const json& j) {
  Falsehood f;
  f.what = lie_of(j.at("what").get<std::string>());
  f.value = j.at("value");
  parse_instant(j, f);
  return f;
}

json instant_json(std::string_view what, const Instant& at) {
  return {{"what", what},
          {"when", kWhens[static_cast<std::size_t>(at.when)]},
          {"n", at.n},
          {"after_s", at.after_s},
          {"lasts_s", at.lasts_s}};
}

}  // namespace

std::string_view to_string(Happening::Kind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}

bool is_of_link(Happening::Kind kind) {
  return kind == What::deaf || kind == What::silent || kind == What::unplug;
}

sim::RandomRig Case::make_rig() const {
  sim::RigOptions options;
  options.without = without;
  options.lie = lie;
  options.gap_m = gap_m;
  return sim::random_rig(rig, options);
}

std::string to_json_text(const Case& c) {
  json out{{"property", c.property}, {"rig", c.rig}, {"without", c.without}};
  if (c.lie) out["lie"] = {{"stiffness", c.lie->stiffness}, {"reaction", c.lie->reaction}};
  if (c.gap_m) out["gap_m"] = *c.gap_m;
  out["is_within"] = c.is_within;
  out["happenings"] = json::array();
  for (const Happening& h : c.happenings) {
    out["happenings"].push_back(instant_json(to_string(h.kind), h));
  }
  for (const Falsehood& f : c.lies) {
    json lie = instant_json(to_string(f.what), f);
    lie["value"] = f.value;
    out["lies"].push_back(lie);
  }
  if (!c.fault_script.empty()) out["faults"] = json::parse(c.fault_script);
  out["protocol"] = json::parse(c.protocol);
  return out.dump();
}

Case parse_case(const std::string& text) {
  const json j = json::parse(text);
  Case c;
  c.property = j.at("property");
  c.rig = j.at("rig");
  c.without = j.value("without", 0U);
  if (j.contains("lie")) {
    c.lie.emplace();
    c.lie->stiffness = j.at("lie").at("stiffness");
    c.lie->reaction = j.at("lie").at("reaction");
  }
  if (j.contains("gap_m")) c.gap_m = j.at("gap_m");
  c.is_within = j.value("is_within", true);
  for (const json& h : j.at("happenings")) c.happenings.push_back(parse_happening(h));
  if (j.contains("lies")) {
    for (const json& f : j.at("lies")) c.lies.push_back(parse_falsehood(f));
  }
  if (j.contains("faults")) c.fault_script = j.at("faults").dump();
  c.protocol = j.at("protocol").dump();
  return c;
}

}  // namespace lcrig::property
