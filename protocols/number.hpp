// SPDX-License-Identifier: Apache-2.0
// The numbers of a protocol file: literals, and references to parameters and sweep variables. Every
// step contains some; plan and run look up their values in an Environment.
#pragma once

#include <map>
#include <string>

namespace lcrig {

// A number of the file, or a reference "$name" to a parameter or a sweep variable.
struct Number {
  Number() = default;
  explicit Number(double v) : value(v) {}
  double value = 0;  // SI, if `name` is empty
  std::string name;  // parameter or variable, without '$'
  // Where a literal stands in the file and its SI factor there, for advice on what to change.
  std::string pointer;
  double to_si = 1;
};

// Values of parameters and sweep variables, SI.
class Environment {
 public:
  void set(const std::string& name, double si) { values_[name] = si; }
  void unset(const std::string& name) { values_.erase(name); }
  double get(const Number& n) const { return n.name.empty() ? n.value : values_.at(n.name); }
  const std::map<std::string, double>& values() const { return values_; }

 private:
  std::map<std::string, double> values_;
};

}  // namespace lcrig
