// SPDX-License-Identifier: Apache-2.0
// The one table from unit suffix to dimension and SI factor. Names in files and flags end in their
// unit (`speed_mm_s`); values inside the program are SI. Used by the JSON reader and by protocol
// parameters.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/enum_words.hpp"

namespace lcrig {

enum class Dimension {
  none,
  length,
  area,
  mass,
  time,
  speed,
  acceleration,
  force,
  force_rate,
  stiffness,
  pressure,
  pressure_rate,
  frequency,
  voltage,
  capacitance,
  capacitance_rate,
  resistance,
  temperature_difference,
  temperature,  // always degC: a factor alone does not convert it to kelvin
};
template <>
inline constexpr EnumWords<19> kWordsOf<Dimension>{"pure number",  "length",
                                                   "area",         "mass",
                                                   "time",         "speed",
                                                   "acceleration", "force",
                                                   "force rate",   "stiffness",
                                                   "pressure",     "pressure rate",
                                                   "frequency",    "voltage",
                                                   "capacitance",  "capacitance rate",
                                                   "resistance",   "temperature difference",
                                                   "temperature"};

struct Unit {
  std::string_view suffix;  // "mm_s"
  Dimension dimension = Dimension::none;
  double to_si = 1;  // value in SI = value in this unit * to_si
};

std::span<const Unit> all_units();
const Unit* find_unit(std::string_view suffix);  // nullptr when not in the table
std::string for_people(const Unit& unit);  // "mm/s"

// Splits a key before the longest suffix that is in the table: "speed_mm_s" gives "speed" and mm_s.
// Without a known suffix the whole key is the stem and `unit` is nullptr.
struct KeyParts {
  std::string_view stem;
  const Unit* unit = nullptr;
  Dimension dimension() const { return unit ? unit->dimension : Dimension::none; }
  double to_si() const { return unit ? unit->to_si : 1.0; }
};
KeyParts split_key(std::string_view key);

// The end of a name that looks like a unit but is not in the table: "bar", or "cm_s" in
// "speed_cm_s", which is not in seconds. nullopt: the name ends in a unit of the table, or in no
// unit.
struct UnknownUnit {
  std::string_view suffix;
  Dimension dimension = Dimension::none;  // of that unit; none: unknown
};
std::optional<UnknownUnit> find_unknown_unit(std::string_view name);

// "_um, _mm, _m": the units that a message about a wrong suffix lists.
std::string suffixes_of(Dimension d);

}  // namespace lcrig
