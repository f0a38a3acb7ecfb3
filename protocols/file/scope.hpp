// SPDX-License-Identifier: Apache-2.0
// The names that "$name" may refer to at one place of a protocol file, and the reading of numbers
// that may be such references. Used by the parser only.
#pragma once

#include <map>
#include <string>

#include "base/strict_json.hpp"
#include "protocols/number.hpp"

namespace lcrig {

struct ScopeEntry {
  Dimension dimension = Dimension::none;
  double min = 0, max = 0;  // SI; every value it can take
  bool integer = false;
  bool unit_known = true;  // false: its name ends in a unit that nobody knows
  bool bounded = true;  // false: what the file says of its values is wrong, so nothing follows
};

class Scope {
 public:
  void add(const std::string& name, const ScopeEntry& entry) { entries_[name] = entry; }
  void remove(const std::string& name) { entries_.erase(name); }
  bool has(const std::string& name) const { return entries_.contains(name); }
  // While this is set, an unknown name may be due to another mistake in the file.
  void set_names_doubtful(bool doubtful) { doubtful_names_ += doubtful ? 1 : -1; }

  // A literal in the unit given, or "$name" of the same dimension whose whole range fits.
  Number read(const JsonReader& value, Dimension d, double to_si, const Range& si) const;
  Number read_count(const JsonReader& value, std::int64_t min, std::int64_t max) const;
  // The member `stem` + unit suffix.
  Number required(const JsonReader& object, std::string_view stem, Dimension d,
                  const Range& si) const;
  std::optional<Number> optional(const JsonReader& object, std::string_view stem, Dimension d,
                                 const Range& si) const;
  // Least and greatest SI value of a number.
  ScopeEntry bounds(const Number& n, Dimension d) const;

 private:
  const ScopeEntry* find(const JsonReader& value, Dimension d, std::string& name) const;
  std::map<std::string, ScopeEntry> entries_;
  int doubtful_names_ = 0;
};

}  // namespace lcrig
