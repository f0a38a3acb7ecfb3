// SPDX-License-Identifier: Apache-2.0
#include "tests/property/recipe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/property/own_bounds.hpp"

namespace lcrig::property {

namespace {

using json = nlohmann::ordered_json;

constexpr double kPatience_s = 25;  // for one motion
constexpr double kSlack = 0.8;  // of what our own arithmetic allows

double even(int at, double low, double high) {
  return low + (high - low) * at / 1000;
}
double scale(int at, double low, double high) {
  return low * std::pow(high / low, at / 1000.0);
}
// As somebody would type it, never more.
double typed(double value) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3);
  return std::floor(value / unit) * unit;
}

class Writer {
 public:
  Writer(const Recipe& recipe, const sim::RandomRig& rig)
      : recipe_(recipe), rig_(rig), caps_(rig.declared()), contact_(rig) {}

  Written write() {
    settle_limits();
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
  enum class Place { unknown, apart, pressed };

  int base(std::size_t i) const { return recipe_.base[i]; }
  // Some protocols are nothing but fast: what the plan then asks of the stiffness at contact.
  bool is_hasty() const { return recipe_.beyond > 0 && base(2) % 2 == 0; }
  bool is_beyond(const Choice& c) const { return !is_hasty() && c.at[3] % 1000 < recipe_.beyond; }

  // What the force may be, and how far the specimen may give way.
  void settle_limits() {
    limit_N_ = typed(even(base(0), 1.0, 0.6) * rig_.limit_N);
    zeroed_ = base(1) < 500;
    blind_N_ = 0.1 * rig_.limit_N + 6 * rig_.plant.force_noise_N;
    const double zero_N = 5 * rig_.plant.force_noise_N + 0.005 * limit_N_;
    off_N_ = zeroed_ ? zero_N : blind_N_;
    end_N_ = limit_N_ - off_N_;
    most_N_ = 0.7 * end_N_ - off_N_;
    least_N_ = std::min(2 * off_N_ + 10 * rig_.plant.force_noise_N, 0.9 * most_N_);
    room_m_ = rig_.plant.travel_max_m - rig_.plant.contact_travel_m - 0.1e-3;
    while (most_N_ > least_N_ && likely_m(most_N_) > 0.6 * room_m_) most_N_ *= 0.7;
    can_press_ = contact_.is_bounded() && most_N_ > least_N_;
    rise_N_ = std::max(12 * rig_.plant.force_noise_N, even(base(2), 0.02, 0.2) * end_N_);
    if (rise_N_ > 0.6 * end_N_ || likely_m(rise_N_) > 0.5 * room_m_) can_press_ = false;
    settle_search();
    // Contact is called where the search stands, inside of the specimen.
    inside_m_ = 1.3 * (likely_m(rise_N_) + own_stopping_way_m(rig_, search_m_s_)) + 20e-6;
    const double above_m = rig_.plant.contact_travel_m - rig_.plant.travel_min_m;
    clear_m_ = typed(std::min(inside_m_ + even(base(3), 0.05e-3, 4e-3), 0.5 * above_m));
    if (clear_m_ < inside_m_) can_press_ = false;
    depth_m_ = typed(std::max(0.8 * room_m_, 1.2 * likely_m(most_N_)));
    top_m_ = typed(std::max(2 * std::max(written_.gap_m, clear_m_), 1e-3) + 1e-3);
  }

  void settle_search() {
    const double fast = own_fastest_m_s(rig_, rise_N_, rise_N_ + 0.4 * (end_N_ - rise_N_));
    search_m_s_ = typed(std::min(kSlack * fast, 0.9 * caps_.speed_max.si()));
    if (search_m_s_ < 2 * caps_.speed_min.si()) can_press_ = false;
    if (!can_press_) search_m_s_ = 0.1 * caps_.speed_max.si();
    slow_down_ = base(4) > 500;
    asked_m_s_ = search_m_s_;
    if (slow_down_) {
      asked_m_s_ = typed(std::min(scale(base(4), 1, 30) * search_m_s_, caps_.speed_max.si()));
    }
    written_.gap_m =
        std::max(std::min(rig_.gap_m, even(base(5), 0.2, 1) * kPatience_s * search_m_s_), 2e-6);
  }

  double likely_m(double force_N) const {
    const double frame_m = force_N / rig_.plant.frame_stiffness_N_m;
    const double true_m = rig_.specimen().shortening_m(force_N) + frame_m;
    return std::max(true_m, contact_.generous_way_m(force_N));
  }

  json limits_json() const {
    json out{{"force_N", {-typed(blind_N_ * 1.3 + even(base(3), 0, 0.2) * limit_N_), limit_N_}}};
    const double shown_m = rig_.plant.contact_travel_m;
    const bool by_travel = base(7) > 600 || !uses_gap();
    if (by_travel) {
      out["travel_mm"] = {typed_travel(std::max(rig_.plant.travel_min_m, shown_m - top_m_)),
                          typed_travel(rig_.plant.travel_max_m - 0.05e-3)};
    }
    if (!by_travel || base(7) > 800) out["gap_mm"] = {-depth_m_ * 1e3, top_m_ * 1e3};
    if (base(8) > 300 && fastest_ > 0) out["speed_mm_s"] = typed(fastest_ * 1e3 * 1.001);
    return out;
  }
  static double typed_travel(double m) { return std::round(m * 1e6) * 1e-3; }  // mm
  bool uses_gap() const { return style() != Style::blind; }

  json sample() const {
    const double rate = std::clamp(std::round(scale(base(9), 10, 100)), 10.0, 500.0);
    json lcr{{"function", "Cp-D"}, {"frequency_Hz", 1000}, {"level_V", 1}, {"aperture", "fast"}};
    if (base(9) % 2 == 0) lcr["trigger"] = "internal";
    if (base(9) % 3 == 0) lcr["continuous"] = false;
    return {{"lcr", lcr}, {"frame", {{"rate_Hz", rate}}}};
  }

  enum class Style { search, stated, blind };
  Style style() const {
    const int s = base(1) % 100;
    if (!can_press_) return s < 50 ? Style::stated : Style::blind;
    return s < 75 ? Style::search : (s < 88 ? Style::stated : Style::blind);
  }

  json all_steps() {
    json out = json::array();
    if (zeroed_) out.push_back(step("zero", {{"force", true}}));
    if (style() == Style::search) out.push_back(find_contact());
    if (style() == Style::stated) {
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

  // Away from the specimen, wherever it is.
  json finally_steps() {
    json out = json::array();
    const double v = air_m_s(500);
    if (style() == Style::blind) {
      if (!moved_) return out;
      lowest_m_ = std::min(lowest_m_, rig_.plant.contact_travel_m - written_.gap_m);
      out.push_back(step("ramp", {{"to", {{"travel_mm", typed_travel(lowest_m_ - 2e-6)}}},
                                  {"speed_mm_s", v * 1e3},
                                  {"timeout_s", timeout(top_m_ / v)}}));
      return out;
    }
    out.push_back(step("ramp", {{"to", {{"gap_mm", clear_m_ * 1e3}}},
                                {"speed_mm_s", v * 1e3},
                                {"timeout_s", timeout((top_m_ + depth_m_) / v)}}));
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
  double air_m_s(int at) const {
    const double most = 0.95 * caps_.speed_max.si();
    return typed(scale(at, std::min(20e-6, most), most));
  }

  json find_contact() {
    written_.presses = can_press_;
    place_ = Place::apart;
    apart_m_ = back_m();
    // The plan reckons with 3 mm to go where nobody has said.
    const double gap_m = std::max(written_.gap_m, 3.2e-3);
    const double way_s = (gap_m + likely_m(rise_N_)) / search_m_s_ + apart_m_ / asked_m_s_;
    json out = step("find_contact", {{"speed_mm_s", asked_m_s_ * 1e3},
                                     {"force_N", typed(rise_N_)},
                                     {"back_off_mm", apart_m_ * 1e3},
                                     {"timeout_s", timeout(way_s + 60)}});
    if (slow_down_) out["slow_down"] = true;
    const double within_m = 3 * (top_m_ + depth_m_);
    if (base(8) % 2 == 0) out["within_mm"] = typed(within_m * 1e3);
    return out;
  }
  double back_m() const {
    const double most = std::min({1e-3, 0.3 * kPatience_s * search_m_s_, clear_m_});
    return typed(std::max(even(base(8), 0.1, 1) * most, 1e-6) + inside_m_);
  }

  // The fastest to a force that our arithmetic allows; 0: too slow for anybody's patience.
  double press_m_s(double force_N, int at) const {
    if (!can_press_) return 0;
    const double fast = kSlack * own_fastest_m_s(rig_, force_N + off_N_, end_N_);
    const double v = typed(std::min(even(at, 0.3, 1) * fast, 0.9 * caps_.speed_max.si()));
    const double way_m = (place_ == Place::pressed ? 0 : apart_m_) + likely_m(force_N);
    return v < 2 * caps_.speed_min.si() || way_m / v > 4 * kPatience_s ? 0 : v;
  }
  double force_of(int at) const { return typed(even(at, least_N_, most_N_)); }
  // Above the present one.
  double more_force(int at) const {
    if (place_ != Place::pressed) return force_of(at);
    return typed(even(at, std::max(least_N_, 1.03 * force_N_ + 2 * off_N_), most_N_));
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
    if (v == 0 || place_ == Place::unknown || force > most_N_) return wait_instead(out, c);
    json to{{"force_N", force}};
    if (c.at[1] % 5 == 0) to = {{"pressure_kPa", force / probe_m2() * 1e-3}};
    if (c.at[1] % 5 == 1) to = number("force_N", force, true);
    json more = number("speed_mm_s", std::min(v * beyond_by(c), caps_.speed_max.si()) * 1e3,
                       c.at[1] % 7 == 0);
    if (more["speed_mm_s"].is_string()) use(v * beyond_by(c));
    const double way_s = ((place_ == Place::pressed ? 0 : apart_m_) + 2 * likely_m(force)) / v;
    more["timeout_s"] = timeout(way_s);
    const bool until = c.kind % 2 == 0;
    more[until ? "until" : "to"] = to;
    if (until && c.at[2] % 4 == 0) more["overshoot_N"] = limit_N_;
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
  double probe_m2() const {
    return 0.7853981633974483 * rig_.probe_diameter_m * rig_.probe_diameter_m;
  }

  void ease(json& out, const Choice& c) {
    if (place_ != Place::pressed || force_N_ < 1.5 * least_N_) return wait_instead(out, c);
    const double force = typed(even(c.at[0], 0.8 * force_N_, least_N_));
    const double v =
        typed(std::min(kSlack * own_fastest_m_s(rig_, 0, 0.3 * force), 0.9 * caps_.speed_max.si()));
    if (v < 2 * caps_.speed_min.si() || 2 * likely_m(limit_N_) / v > 4 * kPatience_s) {
      return wait_instead(out, c);
    }
    out.push_back(step("move_until", {{"until", {{"force_N", force}}},
                                      {"speed_mm_s", v * 1e3},
                                      {"timeout_s", timeout(2 * likely_m(limit_N_) / v)}}));
    force_N_ = force;
  }

  void back(json& out, const Choice& c) {
    if (place_ == Place::unknown) return blind(out, c);
    const double slow = can_press_ ? search_m_s_ : 10e-6;
    const double most = std::min({clear_m_, kPatience_s * slow, 2e-3});
    const double gap = typed(std::max(even(c.at[0], 0.05, 1) * most, 1e-6) + inside_m_);
    const double v = air_m_s(c.at[1]) * (is_beyond(c) ? scale(c.at[2], 1, 3) : 1);
    out.push_back(step("ramp", {{"to", {{"gap_mm", gap * 1e3}}},
                                {"speed_mm_s", v * 1e3},
                                {"timeout_s", timeout((top_m_ + depth_m_) / v)}}));
    place_ = Place::apart;
    apart_m_ = gap;
    force_N_ = 0;
  }

  // Towards a specimen that may be anywhere, and not as far as it is.
  void blind(json& out, const Choice& c) {
    const double least = std::max(1e-3 * caps_.force_max.si(), 8 * rig_.plant.force_noise_N);
    const double fast = kSlack * own_fastest_m_s(rig_, least, end_N_);
    const double start_m = rig_.plant.contact_travel_m - written_.gap_m;
    const bool away = fast < 2 * caps_.speed_min.si() || c.at[0] < 300;
    const double to_m = away ? start_m - std::min(0.2e-3, 0.4 * (start_m - rig_.plant.travel_min_m))
                             : start_m + even(c.at[0], 0, 0.8) * written_.gap_m;
    const double v = away ? air_m_s(c.at[1]) : typed(std::min(fast, 0.9 * caps_.speed_max.si()));
    const double asked = std::min(v * beyond_by(c), caps_.speed_max.si());
    if (away && is_away_) return wait_instead(out, c);
    if (!away && is_away_) return wait_instead(out, c);
    is_away_ = away;
    lowest_m_ = std::min({lowest_m_, start_m, to_m});
    out.push_back(step("ramp", {{"to", {{"travel_mm", typed_travel(to_m)}}},
                                {"speed_mm_s", asked * 1e3},
                                {"timeout_s", timeout(2e-3 / v + written_.gap_m / v)}}));
  }

  // Into the specimen by travel: no deeper than is free of danger on the stiffest contact.
  void press_by_travel(json& out, const Choice& c) {
    if (!can_press_ || place_ == Place::unknown) return wait_instead(out, c);
    const double free_m = contact_.way_m(end_N_) - contact_.way_m(rise_N_ + off_N_);
    const double depth = typed(even(c.at[0], 0.05, 0.8) * free_m) * beyond_by(c);
    const double v = std::min(air_m_s(c.at[1]) * 0.05, 0.5 * caps_.speed_max.si());
    if (depth < 1e-7 || depth > 0.5 * room_m_) return wait_instead(out, c);
    if (v < 2 * caps_.speed_min.si() || 1e-3 / v > 20 * kPatience_s) return wait_instead(out, c);
    out.push_back(step("ramp", {{"to", {{"gap_mm", -depth * 1e3}}},
                                {"speed_mm_s", typed(v) * 1e3},
                                {"timeout_s", timeout((apart_m_ + depth + 2e-3) / typed(v))}}));
    place_ = Place::pressed;
    force_N_ = 0;  // nobody knows
  }

  const ForceLoop* loop() const {
    if (!caps_.force_hold) return nullptr;
    if (caps_.force_loop) return &*caps_.force_loop;
    return rig_.force_loop ? &*rig_.force_loop : nullptr;
  }
  bool loop_holds(double force_N) const {
    const ForceLoop* l = loop();
    return l != nullptr && contact_.is_bounded() &&
           contact_.stiffness_N_m(1.1 * force_N + off_N_) < kSlack * l->stiffness_max.si();
  }

  // Without contact the device first approaches, and stops as soon as it feels it.
  bool loop_begins(const ForceLoop& l) const {
    if (place_ == Place::pressed && force_N_ > 1.5 * l.contact.si() + 2 * off_N_) return true;
    const double v = l.approach.si(), felt = l.contact.si() + off_N_;
    const bool near = place_ == Place::apart && apart_m_ / v < kPatience_s;
    return near && contact_.force_after_N(felt, own_stopping_way_m(rig_, v)) < kSlack * end_N_;
  }

  void ramp_force(json& out, const Choice& c) {
    const ForceLoop* l = loop();
    if (l != nullptr && place_ == Place::apart && c.at[2] % 3 != 0) press(out, c);
    const double force = force_of(c.at[2]);
    const bool may = can_press_ && l != nullptr && loop_holds(force) && loop_begins(*l);
    if (!may && !(is_beyond(c) && place_ != Place::unknown)) return wait_instead(out, c);
    const double lag_s = l != nullptr ? to_seconds(l->lag) : 0.01;
    const double most = l != nullptr ? l->rate_max.si() : 5;
    const double room = end_N_ - force - off_N_ - (l != nullptr ? l->ripple.si() : 0);
    double rate = std::min(kSlack * most, lag_s > 0 ? kSlack * room / lag_s : most);
    rate = typed(scale(c.at[1], 0.1, 1) * rate);
    if (!(rate > 0) || (force / rate > 4 * kPatience_s)) return wait_instead(out, c);
    out.push_back(step("ramp", {{"to", {{"force_N", force}}},
                                {"force_rate_N_s", typed(rate * beyond_by(c))},
                                {"timeout_s", timeout(limit_N_ / rate + 60)}}));
    place_ = Place::pressed;
    force_N_ = force;
  }

  void hold_force(json& out, const Choice& c) {
    const ForceLoop* l = loop();
    if (l != nullptr && place_ == Place::apart) press(out, c);
    const bool may = l != nullptr && place_ == Place::pressed && loop_holds(force_N_) &&
                     force_N_ > 1.5 * l->contact.si() + 2 * off_N_;
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
    if (style() != Style::search || place_ != Place::apart) return wait_instead(out, c);
    if (apart_m_ < back_m() || apart_m_ > 2 * kPatience_s * search_m_s_) return back(out, c);
    out.push_back(find_contact());
  }
  void measure(json& out, const Choice& c) {
    const int count = 1 + c.at[0] % 4;
    const double each_s = is_beyond(c) ? 0.01 : 0.4;
    out.push_back(step("measure", {{"count", count}, {"within_s", count * each_s}}));
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
    const double high = force_of(c.at[0]), low = typed(std::max(least_N_, 0.5 * high));
    const double v = press_m_s(high, c.at[1]);
    if (v == 0 || place_ == Place::unknown || force_N_ > low) return wait_instead(out, c);
    const std::string name = fmt::format("level{}_N", ++ids_);
    const double way_s = (apart_m_ + 2 * likely_m(high)) / v;
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
  // What this rig cannot do at all, or what the file forgot.
  void impossible(json& out, const Choice& c) {
    if (!is_beyond(c)) return measure(out, c);
    switch (c.at[0] % 4) {
      case 0: return out.push_back(step("place_weight", {{"mass_g", 10}}));
      case 1:
        return out.push_back(
            step("ramp", {{"to", {{"gap_mm", 0.5}}}, {"speed_mm_s", 0.1}, {"timeout_s", 1}}));
      case 2:
        return out.push_back(step("move_until", {{"until", {{"force_N", limit_N_ * 1.2}}},
                                                 {"speed_mm_s", search_m_s_ * 1e3},
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
      case 0: return out.push_back(step("mark", {{"text", "here"}}));
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
  OwnContact contact_;
  Written written_;
  json parameters_ = json::object();
  double limit_N_ = 0, off_N_ = 0, blind_N_ = 0, end_N_ = 0, most_N_ = 0, least_N_ = 0, rise_N_ = 0;
  double room_m_ = 0, inside_m_ = 0, clear_m_ = 0, depth_m_ = 0, top_m_ = 0;
  double search_m_s_ = 0, asked_m_s_ = 0, fastest_ = 0;
  bool can_press_ = false, zeroed_ = false, slow_down_ = false, moved_ = false, is_away_ = false;
  Place place_ = Place::unknown;
  double apart_m_ = 0, force_N_ = 0;  // where the run should be
  double lowest_m_ = 1e9;
  int ids_ = 0;
};

}  // namespace

Written write_protocol(const Recipe& recipe, const sim::RandomRig& rig) {
  return Writer(recipe, rig).write();
}

}  // namespace lcrig::property
