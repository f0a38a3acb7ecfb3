// SPDX-License-Identifier: Apache-2.0
#include "tests/property/recipe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/property/reach.hpp"

namespace lcrig::property {

namespace {

using json = nlohmann::ordered_json;

class Writer {
 public:
  Writer(const Recipe& recipe, const sim::RandomRig& rig)
      : recipe_(recipe), rig_(rig), caps_(rig.declared()), can_(recipe, rig) {}

  Written write() {
    written_.gap_m = can_.gap_m;
    const json steps = all_steps(), last = finally_steps();
    json out{{"format", "load-protocol/1"}, {"name", "random"}};
    if (!parameters_.empty()) out["parameters"] = parameters_;
    out["limits"] = limits_json();
    out["sample"] = sample();
    if (base(6) > 700) out["on_loss"] = base(6) > 850 ? "wait" : "repeat_step";
    if (base(6) > 700) out["on_loss_timeout_s"] = 20;
    out["finally_timeout_s"] = 120;
    out["steps"] = steps;
    out["finally"] = last;
    written_.text = out.dump();
    return written_;
  }

 private:
  using Style = Reach::Style;
  enum class Place { unknown, apart, pressed };

  int base(std::size_t i) const { return recipe_.base[i]; }
  // Some protocols only go too fast, so that the plan depends on the stiffness measured at contact.
  bool is_hasty() const { return recipe_.beyond > 0 && base(2) % 2 == 0; }
  bool is_beyond(const Choice& c) const { return !is_hasty() && c.at[3] % 1000 < recipe_.beyond; }

  json limits_json() const {
    json out{{"force_N",
              {-typed(can_.blind_N * 1.3 + even(base(3), 0, 0.2) * can_.limit_N), can_.limit_N}}};
    const double shown_m = rig_.plant.contact_travel_m;
    const bool by_travel = base(7) > 600 || !uses_gap();
    if (by_travel) {
      out["travel_mm"] = {typed_mm(std::max(rig_.plant.travel_min_m, shown_m - can_.top_m)),
                          typed_mm(rig_.plant.travel_max_m - 0.05e-3)};
    }
    if (!by_travel || base(7) > 800) out["gap_mm"] = {-can_.depth_m * 1e3, can_.top_m * 1e3};
    if (base(8) > 300 && fastest_ > 0) out["speed_mm_s"] = typed(fastest_ * 1e3 * 1.001);
    return out;
  }
  bool uses_gap() const { return can_.style != Style::blind; }

  json sample() const {
    const double rate = std::clamp(std::round(scale(base(9), 10, 100)), 10.0, 500.0);
    json lcr{{"function", "Cp-D"}, {"frequency_Hz", 1000}, {"level_V", 1}, {"aperture", "fast"}};
    if (base(9) % 2 == 0) lcr["trigger"] = "internal";
    if (base(9) % 3 == 0) lcr["continuous"] = false;
    return {{"lcr", lcr}, {"frame", {{"rate_Hz", rate}}}};
  }

  json all_steps() {
    json out = json::array();
    if (can_.zeroed) out.push_back(step("zero", {{"force", true}}));
    if (can_.style == Style::search) out.push_back(find_contact());
    if (can_.style == Style::stated) {
      out.push_back(step("set_gap", {{"gap_mm", written_.gap_m * 1e3}}));
      place_ = Place::apart;
      apart_m_ = written_.gap_m;
    }
    for (const Choice& c : recipe_.steps) add(c, out, true);
    if (out.empty()) out.push_back(step("mark", {{"text", "nothing"}}));
    // A gateway of revision 1 cannot be observed.
    if (rig_.frame.revision < 2) out.push_back(step("hold", {{"hold", "travel"}, {"for_s", 0.1}}));
    return out;
  }

  // Moves away from the specimen, wherever it is.
  json finally_steps() {
    json out = json::array();
    const double v = can_.air_m_s(500);
    if (can_.style == Style::blind) {
      if (!moved_) return out;
      lowest_m_ = std::min(lowest_m_, rig_.plant.contact_travel_m - written_.gap_m);
      out.push_back(step("ramp", {{"to", {{"travel_mm", typed_mm(lowest_m_ - 2e-6)}}},
                                  {"speed_mm_s", v * 1e3},
                                  {"timeout_s", timeout(can_.top_m / v)}}));
      return out;
    }
    out.push_back(step("ramp", {{"to", {{"gap_mm", can_.clear_m * 1e3}}},
                                {"speed_mm_s", v * 1e3},
                                {"timeout_s", timeout((can_.top_m + can_.depth_m) / v)}}));
    return out;
  }

  json step(const char* what, json more) {
    json out{{"id", fmt::format("{}{}", what, ++ids_)}, {"do", what}};
    out.update(more);
    if (more.contains("speed_mm_s")) {
      if (more["speed_mm_s"].is_number()) use(more["speed_mm_s"].get<double>() * 1e-3);
      moved_ = true;
    }
    return out;
  }
  void use(double speed_m_s) { fastest_ = std::max(fastest_, speed_m_s); }
  static double timeout(double expected_s) { return std::ceil(2 * std::min(expected_s, 1e5) + 30); }

  json find_contact() {
    written_.presses = can_.may_press;
    place_ = Place::apart;
    apart_m_ = can_.back_m();
    // Without a stated gap, the plan assumes 3 mm.
    const double gap_m = std::max(written_.gap_m, 3.2e-3);
    const double way_s =
        (gap_m + can_.likely_m(can_.rise_N)) / can_.search_m_s + apart_m_ / can_.asked_m_s;
    json out = step("find_contact", {{"speed_mm_s", can_.asked_m_s * 1e3},
                                     {"force_N", typed(can_.rise_N)},
                                     {"back_off_mm", apart_m_ * 1e3},
                                     {"timeout_s", timeout(way_s + 60)}});
    if (can_.slow_down) out["slow_down"] = true;
    const double within_m = 3 * (can_.top_m + can_.depth_m);
    if (base(8) % 2 == 0) out["within_mm"] = typed(within_m * 1e3);
    return out;
  }
  double air_m() const { return place_ == Place::pressed ? 0 : apart_m_; }
  double press_m_s(double force_N, int at) const { return can_.press_m_s(force_N, air_m(), at); }
  // A force above the present one.
  double more_force(int at) const {
    if (place_ != Place::pressed) return can_.force_of(at);
    return typed(even(at, std::max(can_.least_N, 1.03 * force_N_ + 2 * can_.off_N), can_.most_N));
  }
  void wait_instead(json& out, const Choice& c) {
    if (c.at[0] % 10 == 9) {
      return out.push_back(step("record", {{"until", "confirmed"}, {"timeout_s", 20}}));
    }
    out.push_back(step("record", {{"for_s", even(c.at[0], 0.1, 3)}}));
  }
  double beyond_by(const Choice& c) const {
    if (is_hasty()) return scale(c.at[2], 1, 10);
    return is_beyond(c) ? scale(c.at[2], 1, 100) : 1;
  }
  json number(const char* key, double value, bool as_parameter) {
    if (!as_parameter) return {{key, value}};
    const std::string unit(std::string_view(key).substr(std::string_view(key).find('_')));
    const std::string name = fmt::format("p{}{}", ++ids_, unit);
    parameters_[name] = {{"default", value}, {"min", value / 100}, {"max", value}};
    return {{key, "$" + name}};
  }

  void press(json& out, const Choice& c) {
    const double force = more_force(c.at[0]);
    const double v = press_m_s(force, c.at[1]);
    if (v == 0 || place_ == Place::unknown || force > can_.most_N) return wait_instead(out, c);
    json to{{"force_N", force}};
    if (c.at[1] % 5 == 0) to = {{"pressure_kPa", can_.pressure_kPa(force)}};
    if (c.at[1] % 5 == 1) to = number("force_N", force, true);
    json more = number("speed_mm_s", std::min(v * beyond_by(c), caps_.speed_max.si()) * 1e3,
                       c.at[1] % 7 == 0);
    if (more["speed_mm_s"].is_string()) use(v * beyond_by(c));
    const double way_s = (air_m() + 2 * can_.likely_m(force)) / v;
    more["timeout_s"] = timeout(way_s);
    const bool until = c.kind % 2 == 0;
    more[until ? "until" : "to"] = to;
    if (until && c.at[2] % 4 == 0) more["overshoot_N"] = can_.limit_N;
    if (until && c.at[2] % 4 == 1) final_speed(more, v);
    out.push_back(step(until ? "move_until" : "ramp", more));
    written_.presses = true;
    place_ = Place::pressed;
    force_N_ = force;
  }
  void final_speed(json& more, double v) const {
    more["final_speed_mm_s"] = typed(v * 0.5) * 1e3;
    more["final_from"] = 0.7;
    if (more["speed_mm_s"].is_number()) more["timeout_s"] = more["timeout_s"].get<double>() * 3;
  }

  void ease(json& out, const Choice& c) {
    if (place_ != Place::pressed || force_N_ < 1.5 * can_.least_N) return wait_instead(out, c);
    const double force = typed(even(c.at[0], 0.8 * force_N_, can_.least_N));
    const double v = can_.ease_m_s(force);
    if (v == 0) return wait_instead(out, c);
    out.push_back(
        step("move_until", {{"until", {{"force_N", force}}},
                            {"speed_mm_s", v * 1e3},
                            {"timeout_s", timeout(2 * can_.likely_m(can_.limit_N) / v)}}));
    force_N_ = force;
  }

  void back(json& out, const Choice& c) {
    if (place_ == Place::unknown) return blind(out, c);
    const double slow = can_.may_press ? can_.search_m_s : 10e-6;
    const double most = std::min({can_.clear_m, kPatience_s * slow, 2e-3});
    const double gap = typed(std::max(even(c.at[0], 0.05, 1) * most, 1e-6) + can_.inside_m);
    const double v = can_.air_m_s(c.at[1]) * (is_beyond(c) ? scale(c.at[2], 1, 3) : 1);
    out.push_back(step("ramp", {{"to", {{"gap_mm", gap * 1e3}}},
                                {"speed_mm_s", v * 1e3},
                                {"timeout_s", timeout((can_.top_m + can_.depth_m) / v)}}));
    place_ = Place::apart;
    apart_m_ = gap;
    force_N_ = 0;
  }

  // Moves towards a specimen whose position is not known, but stops before it really is there.
  void blind(json& out, const Choice& c) {
    const double fast = can_.blind_m_s();
    const double start_m = rig_.plant.contact_travel_m - written_.gap_m;
    const bool away = fast < 2 * caps_.speed_min.si() || c.at[0] < 300;
    const double to_m = away ? start_m - std::min(0.2e-3, 0.4 * (start_m - rig_.plant.travel_min_m))
                             : start_m + even(c.at[0], 0, 0.8) * written_.gap_m;
    const double v =
        away ? can_.air_m_s(c.at[1]) : typed(std::min(fast, 0.9 * caps_.speed_max.si()));
    const double asked = std::min(v * beyond_by(c), caps_.speed_max.si());
    if (is_away_) return wait_instead(out, c);
    is_away_ = away;
    lowest_m_ = std::min({lowest_m_, start_m, to_m});
    out.push_back(step("ramp", {{"to", {{"travel_mm", typed_mm(to_m)}}},
                                {"speed_mm_s", asked * 1e3},
                                {"timeout_s", timeout(2e-3 / v + written_.gap_m / v)}}));
  }

  // Presses by travel, no deeper than is safe on the stiffest contact.
  void press_by_travel(json& out, const Choice& c) {
    if (!can_.may_press || place_ == Place::unknown) return wait_instead(out, c);
    const double depth = typed(even(c.at[0], 0.05, 0.8) * can_.free_m()) * beyond_by(c);
    const double v = std::min(can_.air_m_s(c.at[1]) * 0.05, 0.5 * caps_.speed_max.si());
    if (depth < 1e-7 || depth > 0.5 * can_.room_m) return wait_instead(out, c);
    if (v < 2 * caps_.speed_min.si() || 1e-3 / v > 20 * kPatience_s) return wait_instead(out, c);
    out.push_back(step("ramp", {{"to", {{"gap_mm", -depth * 1e3}}},
                                {"speed_mm_s", typed(v) * 1e3},
                                {"timeout_s", timeout((apart_m_ + depth + 2e-3) / typed(v))}}));
    place_ = Place::pressed;
    force_N_ = 0;  // not known
  }

  // Without contact the device first approaches, and stops when it feels contact.
  bool loop_begins(const ForceLoop& l) const {
    if (place_ == Place::pressed && force_N_ > 1.5 * l.contact.si() + 2 * can_.off_N) return true;
    const bool near = place_ == Place::apart && apart_m_ / l.approach.si() < kPatience_s;
    return near && can_.loop_may_land(l);
  }

  void ramp_force(json& out, const Choice& c) {
    const ForceLoop* l = can_.loop();
    if (l != nullptr && place_ == Place::apart && c.at[2] % 3 != 0) press(out, c);
    const double force = can_.force_of(c.at[2]);
    const bool may = can_.may_press && l != nullptr && can_.loop_holds(force) && loop_begins(*l);
    if (!may && !(is_beyond(c) && place_ != Place::unknown)) return wait_instead(out, c);
    const double rate = typed(scale(c.at[1], 0.1, 1) * can_.ramp_N_s(force));
    if (!(rate > 0) || (force / rate > 4 * kPatience_s)) return wait_instead(out, c);
    out.push_back(step("ramp", {{"to", {{"force_N", force}}},
                                {"force_rate_N_s", typed(rate * beyond_by(c))},
                                {"timeout_s", timeout(can_.limit_N / rate + 60)}}));
    place_ = Place::pressed;
    force_N_ = force;
  }

  void hold_force(json& out, const Choice& c) {
    const ForceLoop* l = can_.loop();
    if (l != nullptr && place_ == Place::apart) press(out, c);
    const bool may = l != nullptr && place_ == Place::pressed && can_.loop_holds(force_N_) &&
                     force_N_ > 1.5 * l->contact.si() + 2 * can_.off_N;
    if (!may && !(is_beyond(c) && place_ == Place::pressed)) return wait_instead(out, c);
    json more{{"hold", "force"}, {"for_s", even(c.at[1], 0.2, 4)}};
    if (c.at[0] % 2 == 0) more["force_N"] = force_N_;
    out.push_back(step("hold", more));
  }

  void zero(json& out, const Choice& c) {
    if (place_ == Place::pressed || c.at[0] % 2 == 0) return wait_instead(out, c);
    out.push_back(step("zero", {{"force", true}, {"max_offset_N", rig_.limit_N}}));
  }
  void search_again(json& out, const Choice& c) {
    if (can_.style != Style::search || place_ != Place::apart) return wait_instead(out, c);
    if (apart_m_ < can_.back_m() || apart_m_ > 2 * kPatience_s * can_.search_m_s) {
      return back(out, c);
    }
    out.push_back(find_contact());
  }
  void measure(json& out, const Choice& c) {
    const int count = 1 + c.at[0] % 4;
    const double each_s = is_beyond(c) ? 0.01 : 0.4;
    out.push_back(step("measure", {{"count", count}, {"within_s", count * each_s}}));
  }
  // A question. If it is to go beyond: with a default that does not fit its range.
  void ask(json& out, const Choice& c) {
    const bool wrong = is_beyond(c);
    json more{{"text", "what is it?"}, {"timeout_s", 5 + c.at[1] % 60}};
    switch (wrong ? 1 : c.at[0] % 4) {
      case 0: more["answer"] = "confirmation"; break;
      case 1:
        more.update({{"answer", "number"}, {"range_um", {10, 500}}});
        if (wrong || c.at[2] % 2 == 0) more["default_um"] = wrong ? 600 : 10 + c.at[2] % 400;
        break;
      case 2:
        more.update({{"answer", "choice"}, {"choices", {"one", "other"}}});
        if (c.at[2] % 2 == 0) more["default"] = "other";
        break;
      default:
        more["answer"] = "line";
        if (c.at[2] % 2 == 0) more["default"] = "nothing";
    }
    const bool has_default = more.contains("default") || more.contains("default_um");
    if (has_default && c.at[2] % 4 == 0) more["on_timeout"] = "default";
    if (c.at[2] % 5 == 1) more["on_timeout"] = "wait";
    out.push_back(step("ask", more));
  }
  void set_lcr(json& out, const Choice& c) {
    json more = json::object();
    if (c.at[0] % 2 == 0) more["frequency_Hz"] = is_beyond(c) ? 5e6 : 1000.0 * (1 + c.at[1] % 20);
    if (c.at[0] % 3 == 0) more["level_V"] = 0.5;
    if (c.at[0] % 5 == 0) more["average"] = 1 + c.at[1] % 3;
    if (more.empty()) more["aperture"] = "fast";
    out.push_back(step("set_lcr", more));
  }
  void repeat(json& out, const Choice& c) {
    json inner = json::array();
    Choice press_it = c, back_it = c;
    press_it.kind = 4 + c.at[2] % 2;
    const Place before = place_;
    add(press_it, inner, false);
    if (before != Place::unknown) back(inner, back_it);
    out.push_back(step("repeat", {{"count", 1 + c.at[2] % 3}, {"steps", inner}}));
  }
  void sweep(json& out, const Choice& c) {
    const double high = can_.force_of(c.at[0]), low = typed(std::max(can_.least_N, 0.5 * high));
    const double v = press_m_s(high, c.at[1]);
    if (v == 0 || place_ == Place::unknown || force_N_ > low) return wait_instead(out, c);
    const std::string name = fmt::format("level{}_N", ++ids_);
    const double way_s = (apart_m_ + 2 * can_.likely_m(high)) / v;
    const json load = step("move_until", {{"until", {{"force_N", "$" + name}}},
                                          {"speed_mm_s", v * 1e3},
                                          {"timeout_s", timeout(way_s)}});
    json level = json::array({load});
    measure(level, c);
    json more{{"name", name}};
    if (c.at[2] % 2 == 0) {
      more["values"] = {low, high};
    } else {
      more.update({{"from", low}, {"to", high}, {"count", 2 + c.at[2] % 2}});
    }
    more["steps"] = level;
    out.push_back(step("sweep", more));
    written_.presses = true;
    place_ = Place::pressed;
    force_N_ = high;
  }
  // A step that this rig cannot do at all, or that lacks something it needs.
  void impossible(json& out, const Choice& c) {
    if (!is_beyond(c)) return measure(out, c);
    switch (c.at[0] % 4) {
      case 0: return out.push_back(step("place_weight", {{"mass_g", 10}}));
      case 1:
        return out.push_back(
            step("ramp", {{"to", {{"gap_mm", 0.5}}}, {"speed_mm_s", 0.1}, {"timeout_s", 1}}));
      case 2:
        return out.push_back(step("move_until", {{"until", {{"force_N", can_.limit_N * 1.2}}},
                                                 {"speed_mm_s", can_.search_m_s * 1e3},
                                                 {"timeout_s", 1000}}));
      default:
        return out.push_back(
            step("ramp", {{"to", {{"travel_mm", rig_.plant.travel_max_m * 1e3 + 1}}},
                          {"speed_mm_s", 0.1},
                          {"timeout_s", 5000}}));
    }
  }

  void add(const Choice& c, json& out, bool may_nest) {
    switch (c.kind) {
      case 0:
        if (c.at[1] % 2 == 0) return ask(out, c);
        return out.push_back(step("mark", {{"text", "here"}}));
      case 1: return wait_instead(out, c);
      case 2: return measure(out, c);
      case 3:
        return out.push_back(step("hold", {{"hold", "travel"}, {"for_s", even(c.at[0], 0.2, 4)}}));
      case 4:
      case 5:
      case 6:
      case 7: return press(out, c);
      case 8:
      case 9: return back(out, c);
      case 10: return ease(out, c);
      case 11:
      case 12: return ramp_force(out, c);
      case 13: return hold_force(out, c);
      case 14: return press_by_travel(out, c);
      case 15: return may_nest ? repeat(out, c) : press(out, c);
      case 16: return may_nest ? sweep(out, c) : press(out, c);
      case 17: return c.at[0] % 3 == 0 ? set_lcr(out, c) : zero(out, c);
      case 18: return search_again(out, c);
      default: return impossible(out, c);
    }
  }

  const Recipe& recipe_;
  const sim::RandomRig& rig_;
  const FrameCapabilities& caps_;
  Reach can_;
  Written written_;
  json parameters_ = json::object();
  double fastest_ = 0;
  bool moved_ = false, is_away_ = false;
  Place place_ = Place::unknown;
  double apart_m_ = 0, force_N_ = 0;  // expected state of the run
  double lowest_m_ = 1e9;
  int ids_ = 0;
};

}  // namespace

Written write_protocol(const Recipe& recipe, const sim::RandomRig& rig) {
  return Writer(recipe, rig).write();
}

}  // namespace lcrig::property
