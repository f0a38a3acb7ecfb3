// SPDX-License-Identifier: Apache-2.0
// Follows the advice of refusals as a person would.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/property/own_bounds.hpp"
#include "tests/property/trial.hpp"

namespace lcrig::property {

namespace {

using json = nlohmann::ordered_json;
constexpr int kPatience = 25;  // most refusals of one protocol
// Less than any rig of these tests needs to press.
constexpr double kGentleDepth_mm = 1e-4, kGentleForce_N = 1e-4, kGentlePressure_kPa = 1e-3;

bool has(const std::string& text, std::string_view words) {
  return text.find(words) != std::string::npos;
}

struct Draft {
  Draft() = default;
  json protocol;
  ParameterValues parameters;
  double gap_m = 0, speed_m_s = 0;
  int ramps = 0;  // number of ramps that were put before a hold
};

// "/steps/2/speed_mm_s: 0.864" and "-p speed_mm_s=0.864"
int follow_numbers(const std::string& text, Draft& draft) {
  static const std::regex literal(R"([ (](/[A-Za-z0-9_/]+): (-?[0-9][-+.0-9e]*))");
  static const std::regex parameter(R"(-p ([A-Za-z0-9_]+)=(-?[0-9][-+.0-9e]*))");
  int found = 0;
  for (std::sregex_iterator i(text.begin(), text.end(), literal), end; i != end; ++i, ++found) {
    draft.protocol[json::json_pointer((*i)[1])] = std::stod((*i)[2]);
  }
  for (std::sregex_iterator i(text.begin(), text.end(), parameter), end; i != end; ++i, ++found) {
    draft.parameters[(*i)[1]] = (*i)[2].str();
  }
  return found;
}

std::string pointer_of(const std::string& text) {
  static const std::regex place(R"(:\d+:\d+ (/[A-Za-z0-9_/]*) \()");
  std::smatch m;
  return std::regex_search(text, m, place) ? m[1].str() : "";
}

// Follows advice in words at the step that the advice names.
bool follow_words(const std::string& text, Draft& draft) {
  const std::string pointer = pointer_of(text);
  if (pointer.empty()) return false;
  json& at = draft.protocol[json::json_pointer(pointer)];
  if (has(text, "give limits of this frame, or gap_mm")) return false;
  if (has(text, "set_gap")) {
    json stated{{"id", "stated"}, {"do", "set_gap"}, {"gap_mm", draft.gap_m * 1e3}};
    draft.protocol["steps"].insert(draft.protocol["steps"].begin(), stated);
    return true;
  }
  if (has(text, "use speed_mm_s") && at.contains("force_rate_N_s")) {
    at.erase("force_rate_N_s");
    at["speed_mm_s"] = draft.speed_m_s * 1e3;
    return true;
  }
  if (has(text, "hold the travel") && at.value("do", "") == "hold") {
    for (const char* key : {"force_N", "pressure_kPa"}) at.erase(key);
    at["hold"] = "travel";
    return true;
  }
  if (has(text, "ramp to a force first")) {
    const json::json_pointer place(pointer);
    json ramp{{"id", fmt::format("first{}", draft.ramps++)}, {"do", "ramp"}, {"timeout_s", 3600}};
    for (const char* key : {"force_N", "pressure_kPa"}) {
      if (at.contains(key)) ramp["to"][key] = at[key];
    }
    ramp["speed_mm_s"] = draft.speed_m_s * 1e3;
    json& steps = draft.protocol[place.parent_pointer()];
    steps.insert(steps.begin() + std::stoi(place.back()), ramp);
    return true;
  }
  if (has(text, "use ramp or move_until")) {
    at = {{"id", at.at("id")}, {"do", "mark"}, {"text", "no weights"}};
    return true;
  }
  static const std::regex offers(R"(a (frequency|level) of [^,]+, the meter offers \S+ to (\S+) )");
  std::smatch m;
  if (!std::regex_search(text, m, offers)) return false;
  at[m[1] == "frequency" ? "frequency_Hz" : "level_V"] = std::stod(m[2]);
  return true;
}

// Makes every number of a step as gentle as a person could write it for this rig.
void make_gentle(json& at, double speed_mm_s) {
  if (!at.is_structured()) return;
  for (auto& [key, value] : at.items()) {
    if (key == "speed_mm_s") value = speed_mm_s;
    if (key == "gap_mm" && value.is_number() && value < 0) value = -kGentleDepth_mm;
    if (key == "force_N") value = kGentleForce_N;
    if (key == "pressure_kPa") value = kGentlePressure_kPa;
    make_gentle(value, speed_mm_s);
  }
}

// "No change can help" is true only if even the gentlest form of the step is refused at that step.
Broken truly_nothing_helps(const Case& c, Draft draft, const std::string& text) {
  const std::string pointer = pointer_of(text);
  if (pointer.empty()) return {};
  make_gentle(draft.protocol[json::json_pointer(pointer)],
              c.make_rig().declared().speed_min.si() * 1e3);
  Case gentle = c;
  gentle.protocol = draft.protocol.dump();
  Trial t(gentle);
  t.plan_only(draft.parameters);
  if (!t.is_accepted() && pointer_of(t.world().refused->what) == pointer) return {};
  return {
      fmt::format("advice: said that no change helps, but a gentle step is accepted: {}", text)};
}

}  // namespace

Broken advice_is_good(const Case& c, Counters& counters) {
  Draft draft;
  draft.protocol = json::parse(c.protocol);
  draft.gap_m = c.make_rig().gap_m;
  draft.speed_m_s = c.make_rig().declared().speed_min.si() * 10;
  std::map<std::string, int> told;  // number of refusals of each place
  for (int i = 0; i < kPatience; ++i) {
    Case again = c;
    again.protocol = draft.protocol.dump();
    Trial t(again);
    t.plan_only(draft.parameters);
    if (t.is_accepted()) {
      ++counters["advice led to acceptance"];
      return {};
    }
    const std::string text = t.world().refused->what;
    if (has(text, "no change of the protocol can help")) {
      ++counters["refused: no change helps"];
      return truly_nothing_helps(c, std::move(draft), text);
    }
    if (++told[pointer_of(text)] > 5) {
      return {fmt::format("advice: followed five times, and still refused: {}", text)};
    }
    if (follow_numbers(text, draft) > 0) {
      ++counters["refused with a number"];
    } else if (follow_words(text, draft)) {
      ++counters["refused with words"];
    } else {
      return {fmt::format("advice: there is none in: {}", text)};
    }
  }
  return {"advice: there is no end of it"};
}

}  // namespace lcrig::property
