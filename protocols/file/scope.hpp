// SPDX-License-Identifier: Apache-2.0
// The names that "$name" may refer to at one place of a protocol file. Reads numbers that may be
// such references. Used by the parser only.
#pragma once

#include <map>
#include <string>

#include "base/strict_json.hpp"
#include "protocols/number.hpp"

namespace lcrig {

struct ScopeEntry {
  Dimension dimension = Dimension::none;
  double min = 0, max = 0;  // SI; bounds of the values it can take
  bool integer = false;
  bool unit_known = true;  // false: its name ends in an unknown unit
  bool bounded = true;  // false: its bounds in the file are wrong, so no use of it is checked
                        // against them
};

class Scope {
 public:
  void add(const std::string& name, const ScopeEntry& entry) { entries_[name] = entry; }
  void remove(const std::string& name) { entries_.erase(name); }
  bool has(const std::string& name) const { return entries_.contains(name); }
  // While this is set, an unknown name may be the consequence of another mistake in the file.
  void set_names_doubtful(bool doubtful) { doubtful_names_ += doubtful ? 1 : -1; }

  // Reads a literal in the given unit, or a "$name" of the same dimension whose whole range fits.
  Number read(const JsonReader& value, Dimension d, double to_si, const Range& si) const;
  Number read_count(const JsonReader& value, std::int64_t min, std::int64_t max) const;
  // Reads the member whose key is `stem` with a unit suffix.
  Number required(const JsonReader& object, std::string_view stem, Dimension d,
                  const Range& si) const;
  std::optional<Number> optional(const JsonReader& object, std::string_view stem, Dimension d,
                                 const Range& si) const;
  // Smallest and largest SI value of a number.
  ScopeEntry bounds(const Number& n, Dimension d) const;

 private:
  const ScopeEntry* find(const JsonReader& value, Dimension d, std::string& name) const;
  std::map<std::string, ScopeEntry> entries_;
  int doubtful_names_ = 0;
};

}  // namespace lcrig
