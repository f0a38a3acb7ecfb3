// SPDX-License-Identifier: Apache-2.0
#include "base/units.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr Unit kUnits[] = {
    {"count", Dimension::none, 1},
    {"percent", Dimension::none, 1e-2},
    {"um", Dimension::length, 1e-6},
    {"mm", Dimension::length, 1e-3},
    {"m", Dimension::length, 1},
    {"mm2", Dimension::area, 1e-6},
    {"m2", Dimension::area, 1},
    {"mg", Dimension::mass, 1e-6},
    {"g", Dimension::mass, 1e-3},
    {"kg", Dimension::mass, 1},
    {"us", Dimension::time, 1e-6},
    {"ms", Dimension::time, 1e-3},
    {"s", Dimension::time, 1},
    {"min", Dimension::time, 60},
    {"h", Dimension::time, 3600},
    {"um_s", Dimension::speed, 1e-6},
    {"mm_s", Dimension::speed, 1e-3},
    {"mm_min", Dimension::speed, 1e-3 / 60},
    {"m_s", Dimension::speed, 1},
    {"mm_s2", Dimension::acceleration, 1e-3},
    {"m_s2", Dimension::acceleration, 1},
    {"mN", Dimension::force, 1e-3},
    {"N", Dimension::force, 1},
    {"kN", Dimension::force, 1e3},
    {"mN_s", Dimension::force_rate, 1e-3},
    {"N_s", Dimension::force_rate, 1},
    {"N_min", Dimension::force_rate, 1.0 / 60},
    {"N_m", Dimension::stiffness, 1},
    {"N_mm", Dimension::stiffness, 1e3},
    {"N_um", Dimension::stiffness, 1e6},
    {"Pa", Dimension::pressure, 1},
    {"kPa", Dimension::pressure, 1e3},
    {"MPa", Dimension::pressure, 1e6},
    {"kPa_s", Dimension::pressure_rate, 1e3},
    {"Hz", Dimension::frequency, 1},
    {"kHz", Dimension::frequency, 1e3},
    {"mV", Dimension::voltage, 1e-3},
    {"V", Dimension::voltage, 1},
    {"fF", Dimension::capacitance, 1e-15},
    {"pF", Dimension::capacitance, 1e-12},
    {"nF", Dimension::capacitance, 1e-9},
    {"uF", Dimension::capacitance, 1e-6},
    {"F", Dimension::capacitance, 1},
    {"fF_s", Dimension::capacitance_rate, 1e-15},
    {"pF_s", Dimension::capacitance_rate, 1e-12},
    {"F_s", Dimension::capacitance_rate, 1},
    {"ohm", Dimension::resistance, 1},
    {"kohm", Dimension::resistance, 1e3},
    {"Mohm", Dimension::resistance, 1e6},
    {"K", Dimension::temperature_difference, 1},
    {"degC", Dimension::temperature, 1},
};

// Units that the table lacks but people use, to recognise them in wrong keys. A rate of them is
// recognised by its two parts.
struct ForeignUnit {
  std::string_view suffix;
  Dimension dimension;
};
constexpr ForeignUnit kForeignUnits[] = {
    {"cm", Dimension::length},
    {"nm", Dimension::length},
    {"inch", Dimension::length},
    {"inches", Dimension::length},
    {"mil", Dimension::length},
    {"ft", Dimension::length},
    {"micron", Dimension::length},
    {"microns", Dimension::length},
    {"cm2", Dimension::area},
    {"um2", Dimension::area},
    {"lb", Dimension::mass},
    {"ug", Dimension::mass},
    {"ns", Dimension::time},
    {"sec", Dimension::time},
    {"seconds", Dimension::time},
    {"minutes", Dimension::time},
    {"hours", Dimension::time},
    {"uN", Dimension::force},
    {"cN", Dimension::force},
    {"lbf", Dimension::force},
    {"gf", Dimension::force},
    {"kgf", Dimension::force},
    {"N_cm", Dimension::stiffness},
    {"kN_mm", Dimension::stiffness},
    {"mN_um", Dimension::stiffness},
    {"mN_mm", Dimension::stiffness},
    {"bar", Dimension::pressure},
    {"mbar", Dimension::pressure},
    {"psi", Dimension::pressure},
    {"hPa", Dimension::pressure},
    {"GPa", Dimension::pressure},
    {"atm", Dimension::pressure},
    {"mmHg", Dimension::pressure},
    {"N_mm2", Dimension::pressure},
    {"MHz", Dimension::frequency},
    {"GHz", Dimension::frequency},
    {"mHz", Dimension::frequency},
    {"uV", Dimension::voltage},
    {"kV", Dimension::voltage},
    {"aF", Dimension::capacitance},
    {"mF", Dimension::capacitance},
    {"degC", Dimension::temperature_difference},
    {"mK", Dimension::temperature_difference},
};

// Wrong capitals make another unit: `force_kn` is not in kN.
bool is_same_but_for_capitals(std::string_view a, std::string_view b) {
  return lower_case(a) == lower_case(b);
}

std::optional<Dimension> foreign_dimension(std::string_view suffix) {
  const auto* foreign = std::ranges::find(kForeignUnits, suffix, &ForeignUnit::suffix);
  if (foreign != std::end(kForeignUnits)) return foreign->dimension;
  // One letter is a name, not a unit: `level_n` counts something.
  if (suffix.size() < 2) return std::nullopt;
  for (const Unit& unit : kUnits) {
    if (unit.dimension != Dimension::none && is_same_but_for_capitals(unit.suffix, suffix)) {
      return unit.dimension;
    }
  }
  return std::nullopt;
}

Dimension rate_of(Dimension d) {
  switch (d) {
    case Dimension::length: return Dimension::speed;
    case Dimension::force: return Dimension::force_rate;
    case Dimension::pressure: return Dimension::pressure_rate;
    case Dimension::capacitance: return Dimension::capacitance_rate;
    default: return Dimension::none;
  }
}

// The dimension of a rate in foreign units: "cm_s", "N_h".
std::optional<Dimension> foreign_rate(std::string_view suffix) {
  const auto at = suffix.rfind('_');
  if (at == suffix.npos) return std::nullopt;
  const Unit* per = find_unit(suffix.substr(at + 1));
  const auto what = suffix.substr(0, at);
  const Unit* known = find_unit(what);
  const auto dimension = known != nullptr ? known->dimension : foreign_dimension(what);
  if (per == nullptr || per->dimension != Dimension::time || !dimension) return std::nullopt;
  const Dimension rate = rate_of(*dimension);
  return rate == Dimension::none ? std::nullopt : std::optional(rate);
}

}  // namespace

std::span<const Unit> all_units() {
  return kUnits;
}

const Unit* find_unit(std::string_view suffix) {
  const auto* it = std::ranges::find(kUnits, suffix, &Unit::suffix);
  return it == std::end(kUnits) ? nullptr : it;
}

KeyParts split_key(std::string_view key) {
  // From the left, so that the longest suffix wins: speed_mm_s is not in seconds.
  for (auto at = key.find('_', 1); at != std::string_view::npos; at = key.find('_', at + 1)) {
    if (const Unit* unit = find_unit(key.substr(at + 1))) return {key.substr(0, at), unit};
  }
  return {key, nullptr};
}

std::string for_people(const Unit& unit) {
  std::string out(unit.suffix);
  std::ranges::replace(out, '_', '/');
  return out;
}

std::optional<UnknownUnit> find_unknown_unit(std::string_view name) {
  // From the left, as in split_key.
  for (auto at = name.find('_', 1); at != name.npos; at = name.find('_', at + 1)) {
    const auto suffix = name.substr(at + 1);
    if (find_unit(suffix) != nullptr) return std::nullopt;
    auto dimension = foreign_dimension(suffix);
    if (!dimension) dimension = foreign_rate(suffix);
    if (dimension) return UnknownUnit{suffix, *dimension};
  }
  return std::nullopt;
}

std::string suffixes_of(Dimension d) {
  std::string out;
  for (const Unit& unit : kUnits) {
    if (unit.dimension != d) continue;
    out += fmt::format("{}_{}", out.empty() ? "" : ", ", unit.suffix);
  }
  return out;
}

}  // namespace lcrig
