// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/plan_text.hpp"

#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "tools/lcrig/live_line.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

void print_steps(std::ostream& out, const json& steps) {
  fmt::print(out, "{:20} {:14} {:>6} {:>10}  {}\n", "step", "kind", "times", "total", "note");
  for (const json& s : steps) {
    const std::string note = printable(s.at("note").get<std::string>());
    fmt::print(out, "{:20} {:14} {:>6} {:>10}  {}\n", printable(s.at("id").get<std::string>()),
               s.at("do").get<std::string>(), s.at("times").get<std::int64_t>(),
               format_time(s.at("total_s").get<double>()),
               s.at("in_finally").get<bool>() ? "finally. " + note : note);
  }
}

void print_worst(std::ostream& out, const json& plan) {
  const auto number = [&plan](const char* key) { return plan.at(key).get<double>(); };
  if (number("worst_force_N") <= 0) return;
  const json& u = plan.at("force_uncertainty");
  const double noise = u.at("noise_N").get<double>();
  fmt::print(out, "at worst      {:.4g} N of the {:.4g} N allowed, as the load cell shows it\n",
             number("worst_force_N"), number("force_max_N"));
  fmt::print(out,
             "              link or host lost: {:.4g} N; the frame goes on for {:.3g} mm at most\n",
             number("worst_force_without_link_N"), number("way_without_link_mm"));
  fmt::print(
      out, "              true force within {:.2g} N of it: class {:.2g}, zero {:.2g}, noise {}\n",
      number("force_uncertainty_N"), u.at("class_N").get<double>(), u.at("zero_N").get<double>(),
      noise > 0 ? fmt::format("{:.2g} N", noise) : std::string("measured at rest"));
}

// Prints the limits beyond which the run will not trust a value.
void print_watch(std::ostream& out, const json& plan) {
  if (plan.at("worst_force_N").get<double>() <= 0) return;
  const json& w = plan.at("watch");
  const auto number = [&w](const char* key) { return w.at(key).get<double>(); };
  const std::string frozen = w.at("frozen_force_s").is_null()
                                 ? std::string("not noticed by its digits, which are too coarse")
                                 : fmt::format("within {:.2g} s", number("frozen_force_s"));
  fmt::print(out,
             "not believed  a frozen load cell: {}; a drive that stands for {:.2g} s, or runs\n",
             frozen, number("stall_s"));
  fmt::print(
      out,
      "              {:.2g} um against the command; {:.2g} um where nothing was asked; a DONE\n",
      number("against_mm") * 1e3, number("standing_mm") * 1e3);
  fmt::print(out,
             "              that is off by {:.2g} um or {:.2g} N. STOP follows within {:.2g} s\n",
             number("order_travel_mm") * 1e3, number("order_force_N"), number("reply_s"));
  const auto until = [&plan](const char* key) {
    return plan.at(key).is_null() ? std::string("nothing bounds it")
                                  : fmt::format("{:.3g} N", plan.at(key).get<double>());
  };
  fmt::print(out,
             "              until then a cell that freezes may have let through: {};\n"
             "              a drive that turns round under load: {}\n",
             until("worst_force_frozen_N"), until("worst_force_reversed_N"));
}

void print_places(std::ostream& out, const json& plan) {
  const auto places = plan.find("stop_places");
  if (places == plan.end()) return;  // of an older daemon
  const auto count = [&](const char* key) { return places->at(key).get<std::int64_t>(); };
  fmt::print(out, "stop after    {} steps, {} levels, {} cycles, {} repeats", count("steps"),
             count("levels"), count("cycles"), count("repeats"));
  const char* between = "; safe points: ";
  for (const json& point : places->at("safe_points")) {
    fmt::print(out, "{}{} ({})", between, printable(point.at("id").get<std::string>()),
               point.at("times").get<std::int64_t>());
    between = ", ";
  }
  fmt::print(out, "\n");
}

// An older daemon does not send it.
void print_read_backs(std::ostream& out, const json& plan) {
  const json& r = plan.value("read_back", json());
  if (!r.is_object()) return;
  std::string when;
  if (const json& s = r.at("recording_s"); s.is_number()) {
    when = fmt::format("at least every {:.3g} s while it records", s.get<double>());
  }
  if (const json& s = r.at("level_s"); s.is_number()) {
    when += fmt::format("{}at least every {:.3g} s in levels", when.empty() ? "" : ", ",
                        s.get<double>());
  }
  if (!when.empty()) fmt::print(out, "read-backs    of the meter's settings {}\n", when);
  const json& cost = r.at("cost_readings_per_s");
  const auto of = [&cost](const char* aperture) { return cost.at(aperture).get<double>(); };
  if (r.at("recording_s").is_number()) {
    fmt::print(out,
               "              {:.3g} s each: {:.2g} readings a second at FAST, {:.2g} at MED, "
               "{:.2g} at SLOW\n",
               r.at("takes_s").get<double>(), of("fast"), of("medium"), of("slow"));
  }
  fmt::print(out, "settling      no reading for {:.3g} s after a change of settings\n",
             r.at("settling_s").get<double>());
}

void print_travel(std::ostream& out, const json& plan) {
  const json& travel = plan.at("travel_mm");
  fmt::print(out, "travel        {:.4g} to {:.4g} mm{}\n", travel.at(0).get<double>(),
             travel.at(1).get<double>(),
             plan.at("travel_from") == "contact" ? " from contact" : "");
}

}  // namespace

void print_pressure(std::ostream& out, const json& message) {
  if (!message.is_object() || !message.contains("pressure")) return;
  const json& pressure = message.at("pressure");
  const auto words = pressure.is_object() ? pressure.value("words", "") : std::string();
  if (!words.empty()) fmt::print(out, "{}\n", printable(words));
}

void print_plan(std::ostream& out, const json& plan) {
  const auto number = [&plan](const char* key) { return plan.at(key).get<double>(); };
  print_pressure(out, plan);
  print_steps(out, plan.at("steps"));
  fmt::print(out, "\nduration      {}\n", format_time(number("duration_s")));
  if (const double hand_s = plan.value("hand_s", 0.0); hand_s > 0) {
    fmt::print(out, "by hand       {} of it needs a person\n", format_time(hand_s));
  }
  fmt::print(out, "readings      {} of measure steps, about {} recorded in all\n",
             plan.at("measure_readings").get<std::int64_t>(),
             plan.at("lcr_readings").get<std::int64_t>());
  const double rate_Hz = plan.value("frame_rate_Hz", 0.0);  // an older daemon does not send it
  if (const auto samples = plan.at("frame_samples").get<std::int64_t>();
      samples > 0 && rate_Hz > 0) {
    fmt::print(out, "samples       about {} of the frame, {:.6g} a second\n", samples, rate_Hz);
  }
  fmt::print(out, "peak force    {:.4g} N, overshoot of {:.2g} N expected\n",
             number("peak_force_N"), number("overshoot_N"));
  if (plan.value("weights", false)) {
    fmt::print(
        out,
        "at worst      {:.4g} N of the {:.4g} N allowed, if each weight is the one asked for\n",
        number("worst_force_N"), number("force_max_N"));
  } else {
    print_worst(out, plan);
    print_watch(out, plan);
    print_travel(out, plan);
  }
  print_read_backs(out, plan);
  print_places(out, plan);
  fmt::print(out, "database      about {:.1f} MB\n", number("database_bytes") * 1e-6);
  const auto note = plan.at("aperture_note").get<std::string>();
  if (!note.empty()) fmt::print(out, "aperture      {}\n", printable(note));
  for (const json& assumption : plan.at("assumptions")) {
    fmt::print(out, "assumed       {}\n", printable(assumption.get<std::string>()));
  }
}

}  // namespace lcrig::cli
