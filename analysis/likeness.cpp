// SPDX-License-Identifier: Apache-2.0
#include "analysis/likeness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

// Above this impedance a meter of the 4284A's design measures in its highest range, so that one
// reference resistor determines the gain (Agilent 4284A operation manual, measurement ranges; the
// table of the LCR-6100 itself is not known).
constexpr double kTopRange_ohm = 100e3;
// Assumed where a run does not show its creep, per decade: as much as soft elastomers of pressure
// sensors creep (docs/analysis.md, "Comparisons"). Beyond a tenth of a decade, in which it changes
// a result by one percent, nothing is assumed.
constexpr double kAssumedCreep = 0.1;
constexpr double kSameTime_decades = 0.1;
// Creep is known over the decades of time that a hold shows. Beyond one the law is a guess.
constexpr double kMost_decades = 1;

// Two settings are equal if they differ by no more than what the digits of a read-back leave open.
bool same_setting(double a, double b) {
  constexpr double kDigits = 1e-5;
  return std::abs(a - b) <= kDigits * std::abs(b);
}

std::string run_name(const RunAnalysis& a) {
  return fmt::format("run {}", a.run);
}

using Identity = std::optional<std::string> RunConditions::*;

// Empty: both runs state the same.
std::string unlike_identity(const RunAnalysis& from, const RunAnalysis& to, Identity identity,
                            const char* what) {
  const auto &a = from.conditions.*identity, &b = to.conditions.*identity;
  if (!a && !b) return fmt::format("neither run proves which {} it used", what);
  if (!a || !b)
    return fmt::format("{} does not prove which {} it used", run_name(a ? to : from), what);
  return *a == *b ? "" : fmt::format("{} against {}", *a, *b);
}

// The same correction is in force, or the same meter is without one.
std::string unlike_correction(const CorrectionState& a, const CorrectionState& b, const char* kind,
                              bool simulated) {
  if (!a.on || !b.on) return fmt::format("the state of the {} correction is not recorded", kind);
  if (*a.on != *b.on) return fmt::format("the {} correction is on in only one run", kind);
  if (!*a.on || simulated) return "";  // nothing corrects a simulated meter between two runs
  if (!a.made_unix_ns || !b.made_unix_ns) {
    return fmt::format("it is not recorded when the {} correction was made", kind);
  }
  return *a.made_unix_ns == *b.made_unix_ns
             ? ""
             : fmt::format("the {} correction was made again between the runs", kind);
}

std::string unlike_meter(const RunAnalysis& from, const RunAnalysis& to) {
  const RunConditions &a = from.conditions, &b = to.conditions;
  if (auto words = unlike_identity(from, to, &RunConditions::meter, "meter"); !words.empty()) {
    return words;
  }
  if (!a.setting || !b.setting || !same_setting(a.setting->frequency_Hz, b.setting->frequency_Hz) ||
      !same_setting(a.setting->level_V, b.setting->level_V)) {
    return "other settings of the meter";
  }
  if (!a.corrections || !b.corrections) return "the meter's corrections are not recorded";
  const bool simulated = a.simulated && b.simulated;
  auto words = unlike_correction(a.corrections->open, b.corrections->open, "open", simulated);
  if (words.empty()) {
    words = unlike_correction(a.corrections->short_circuit, b.corrections->short_circuit, "short",
                              simulated);
  }
  if (!words.empty()) return words;
  const bool top = a.impedance_ohm > kTopRange_ohm && b.impedance_ohm > kTopRange_ohm;
  return top ? "" : "the meter may have measured in different ranges";
}

std::string unlike_cell(const RunAnalysis& from, const RunAnalysis& to) {
  const bool a_weights = from.conditions.dead_weights, b_weights = to.conditions.dead_weights;
  if (a_weights != b_weights) {
    return fmt::format("{} has weights in its place", run_name(a_weights ? from : to));
  }
  if (a_weights) return "both runs have weights in its place, and no run records which they were";
  auto words = unlike_identity(from, to, &RunConditions::cell, "load cell");
  const double a = from.conditions.force_class_percent, b = to.conditions.force_class_percent;
  if (words.empty() && a != b) words = fmt::format("force class {:g} against {:g}", a, b);
  return words;
}

std::string unlike_probe(const RunAnalysis& from, const RunAnalysis& to) {
  auto words = unlike_identity(from, to, &RunConditions::probe, "probe");
  if (words.empty() && from.conditions.probe_diameter_m != to.conditions.probe_diameter_m) {
    words = "one name, but two diameters";
  }
  return words;
}

std::string mm(double m) {
  return fmt::format("{:g} mm", m * 1e3);
}

// Both diameters may lie at their limits.
bool differ(double a_m, double b_m, double limits_m) {
  return std::abs(a_m - b_m) > limits_m * (1 + 1e-9);
}

const char* kind_words(LoadKind kind) {
  switch (kind) {
    case LoadKind::held: return "holds each load";
    case LoadKind::rising: return "measures while the load grows";
    case LoadKind::turning: return "turns at the peak";
    case LoadKind::mixed: return "holds some peaks and passes others";
  }
  return "";
}

const char* branch_words(Direction direction) {
  return direction == Direction::up ? "the loading branch" : "the unloading branch";
}

// Creep in parts of the result per decade of time, with its own error. nullopt: not known.
std::optional<double> creep_of(const RunAnalysis& a) {
  if (!a.creep || !a.creep.estimate->standard_error) return std::nullopt;
  return std::hypot(a.creep.value(), *a.creep.estimate->standard_error) / 100;
}

std::string time_words(const LoadState& load) {
  return fmt::format("{:.3g} s", std::pow(10, *load.log10_s));
}

}  // namespace

std::vector<SourceLikeness> compare_sources(const RunAnalysis& from, const RunAnalysis& to) {
  const auto words = [&from](const char* kind, Identity identity) {
    return fmt::format("{} {}", kind, (from.conditions.*identity).value_or(""));
  };
  return {{ErrorSource::meter, words("meter", &RunConditions::meter), unlike_meter(from, to)},
          {ErrorSource::cell, words("load cell", &RunConditions::cell), unlike_cell(from, to)},
          {ErrorSource::probe, words("probe", &RunConditions::probe), unlike_probe(from, to)}};
}

Obstacles unlike_settings(const RunAnalysis& from, const RunAnalysis& to) {
  const RunConditions &a = from.conditions, &b = to.conditions;
  if (!a.setting || !b.setting) {
    return {
        {fmt::format("{} does not record the meter's settings", run_name(a.setting ? to : from)),
         "measure both under recorded settings"}};
  }
  Obstacles out;
  const auto add = [&out](std::string reason) {
    out.push_back({std::move(reason),
                   "a capacitance under other settings is another quantity: measure both under "
                   "the same"});
  };
  if (a.measured != b.measured) {
    add(fmt::format("{} measured {}, {} measured {}", run_name(from), a.measured, run_name(to),
                    b.measured));
  }
  const auto compare = [&add](double from_value, double to_value, const char* words,
                              const char* unit) {
    if (same_setting(from_value, to_value)) return;
    add(fmt::format("measured {0} {2:g} {1} and {3} {4:g} {1}", words, unit, from_value,
                    std::string_view(words) == "at" ? "at" : "of", to_value));
  };
  compare(a.setting->frequency_Hz, b.setting->frequency_Hz, "at", "Hz");
  compare(a.setting->level_V, b.setting->level_V, "with a level of", "V");
  compare(a.setting->bias_V.value_or(0), b.setting->bias_V.value_or(0), "with a bias of", "V");
  return out;
}

std::optional<Unlike> unlike_corrections(const RunAnalysis& from, const RunAnalysis& to) {
  const auto &a = from.conditions.corrections, &b = to.conditions.corrections;
  if (!a || !b || !a->open.on || !b->open.on || *a->open.on == *b->open.on) return std::nullopt;
  return Unlike{fmt::format("the open correction was off in {}: its C0 contains the leads, and "
                            "their capacitance has no known limit",
                            run_name(*a->open.on ? to : from)),
                "measure both with the open correction on, or state the limit: --stray-limit-fF"};
}

bool are_alike_over_disc(const RunAnalysis& from, const RunAnalysis& to) {
  return from.pressure.on_disc() && to.pressure.on_disc();
}

Obstacles unlike_contact(const RunAnalysis& from, const RunAnalysis& to) {
  const PressureArea &a = from.pressure, &b = to.pressure;
  Obstacles out;
  const auto add = [&out](std::string reason, const char* remedy) {
    out.push_back({std::move(reason), remedy});
  };
  if (a.on != b.on) {
    add(fmt::format("pressures on the {} in {}, on the {} in {}", to_string(a.on), run_name(from),
                    to_string(b.on), run_name(to)),
        "state the pressures of both on the same body");
  } else if (a.on == PressureOn::disc) {
    return out;  // the whole disc is pressed
  }
  const auto &probe_a = from.conditions.probe_diameter_m, &probe_b = to.conditions.probe_diameter_m;
  if (!probe_a || !probe_b) {
    add(fmt::format("{} does not record the probe's diameter", run_name(probe_a ? to : from)),
        "measure both with a known probe");
  } else if (differ(*probe_a, *probe_b, a.probe_limit_m + b.probe_limit_m)) {
    add(fmt::format("probes of {} and {}: the same pressure loads other parts of the specimen",
                    mm(*probe_a), mm(*probe_b)),
        "measure both under probes of one diameter");
  }
  const auto &disc_a = a.disc_diameter_m, &disc_b = b.disc_diameter_m;
  const bool discs =
      disc_a && disc_b && differ(*disc_a, *disc_b, disc_limit_m(*disc_a) + disc_limit_m(*disc_b));
  if (discs) {
    add(fmt::format("discs of {} and {}: the same pressure under the probe is another one on the "
                    "disc",
                    mm(*disc_a), mm(*disc_b)),
        "measure both under probes that cover the disc, or with discs of one diameter");
  }
  if (!discs && a.presses_part() == b.presses_part()) return out;
  for (const RunAnalysis* run : {&from, &to}) {
    if (!run->pressure.presses_part()) continue;
    add(fmt::format("the probe of {} presses only a part of the disc of {}",
                    mm(*run->pressure.probe_diameter_m), run_name(*run)),
        "measure both under probes that cover the disc, or with discs of one diameter");
  }
  return out;
}

std::string unknown_disc(const RunAnalysis& from, const RunAnalysis& to) {
  const bool a = from.conditions.disc_diameter_m.has_value();
  if (a == to.conditions.disc_diameter_m.has_value()) return {};
  return fmt::format("the disc of {}, whose diameter is not known", run_name(a ? to : from));
}

Obstacles unlike_loading(const LoadState& from, const LoadState& to, const RunAnalysis& from_run,
                         const RunAnalysis& to_run) {
  Obstacles out;
  if (from.kind != to.kind || from.kind == LoadKind::mixed) {
    out.push_back({fmt::format("{} {}, {} {}", run_name(from_run), kind_words(from.kind),
                               run_name(to_run), kind_words(to.kind)),
                   "measure both with one protocol"});
  }
  if (from.direction != to.direction) {
    out.push_back(
        {fmt::format("{} refers to {}, {} to {}", run_name(from_run), branch_words(from.direction),
                     run_name(to_run), branch_words(to.direction)),
         "measure the same branch in both"});
  }
  return out;
}

std::optional<Unlike> unlike_peak(const LoadState& from, const LoadState& to,
                                  const RunAnalysis& from_run, const RunAnalysis& to_run) {
  const bool known = from.peak_kPa && to.peak_kPa;
  const double a = known ? *from.peak_kPa : from.peak_N, b = known ? *to.peak_kPa : to.peak_N;
  if (is_near(a, b)) return std::nullopt;
  const char* unit = known ? "kPa" : "N";
  return Unlike{fmt::format("a dynamic range holds for its peak: {:.4g} {} in {}, {:.4g} {} in {}",
                            a, unit, run_name(from_run), b, unit, run_name(to_run)),
                "load both to the same peak"};
}

TimeLikeness compare_times(const LoadState& from, const LoadState& to, const RunAnalysis& from_run,
                           const RunAnalysis& to_run) {
  TimeLikeness out;
  if (!from.log10_s || !to.log10_s) {
    out.unlike = Unlike{fmt::format("the time under load of {} is not known",
                                    run_name(from.log10_s ? to_run : from_run)),
                        "record the force of both"};
    return out;
  }
  out.decades = std::abs(*from.log10_s - *to.log10_s);
  const auto a = creep_of(from_run), b = creep_of(to_run);
  const std::string times =
      fmt::format("under load for {} and for {}", time_words(from), time_words(to));
  if (out.decades > kMost_decades) {
    out.unlike = Unlike{times + ": more than a factor of ten apart", "measure after equal times"};
  } else if (out.decades > kSameTime_decades && (!a || !b)) {
    out.unlike = Unlike{
        fmt::format("{}, and the creep of {} is not known", times, run_name(a ? to_run : from_run)),
        "measure after equal times, or with loads that are held for 2 s or more"};
  }
  out.assumed = !a || !b;
  out.relative = out.decades * std::max(a.value_or(kAssumedCreep), b.value_or(kAssumedCreep));
  return out;
}

std::string origin_of(const RunConditions& c) {
  return c.replayed ? "replayed" : c.simulated ? "simulated" : "";
}

std::vector<std::string> name_differences(const RunAnalysis& from, const RunAnalysis& to) {
  const RunConditions &a = from.conditions, &b = to.conditions;
  std::vector<std::string> out;
  if (origin_of(a) != origin_of(b)) {
    const auto word = [](const RunConditions& c) {
      const std::string origin = origin_of(c);
      return origin.empty() ? "measured" : origin;
    };
    out.push_back(
        fmt::format("{} is {}, {} is {}", run_name(from), word(a), run_name(to), word(b)));
  }
  if (a.disc_diameter_m && b.disc_diameter_m && *a.disc_diameter_m != *b.disc_diameter_m) {
    out.push_back(fmt::format("discs of {} and {}: a capacitance grows with the area",
                              mm(*a.disc_diameter_m), mm(*b.disc_diameter_m)));
  }
  if (from.specimen == to.specimen && a.specimen_text != b.specimen_text) {
    out.push_back(fmt::format("the file of specimen {} was another", from.specimen));
  }
  for (const RunAnalysis* run : {&from, &to}) {
    if (run->unproven_readings > 0) {
      out.push_back(fmt::format("{} readings of {} are unproven and do not count",
                                run->unproven_readings, run_name(*run)));
    }
    if (run->exit_status == ExitStatus::success) continue;
    out.push_back(
        fmt::format("{} ended with {}", run_name(*run), to_string(run->exit_status, "?")));
  }
  return out;
}

}  // namespace lcrig
