// SPDX-License-Identifier: Apache-2.0
#include "protocols/file/scope.hpp"

#include "base/key_words.hpp"
#include "base/near_word.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

std::string expected_dimension(Dimension d) {
  if (d == Dimension::none) return "expected a pure number";
  return fmt::format("expected a {} ({})", to_string(d), suffixes_of(d));
}

std::string dimension_words(const std::string& name, Dimension d) {
  const bool plain = d == Dimension::none && split_key(name).unit == nullptr;
  return fmt::format("a {}{}", to_string(d), plain ? ", for its name ends in no unit" : "");
}

}  // namespace

// nullptr when the value is not a usable reference; then it is refused.
const ScopeEntry* Scope::find(const JsonReader& value, Dimension d, std::string& name) const {
  const std::string text = value.string();
  if (text.size() < 2 || text[0] != '$') {
    const auto guess = entries_.contains(text) ? guess_words("$" + text, {", ", '"'}) : "";
    value.refuse(fmt::format("\"{}\"{} expected a number or \"$name\" of a parameter",
                             printable(text), or_comma(guess)));
    return nullptr;
  }
  name = text.substr(1);
  const auto it = entries_.find(name);
  if (it == entries_.end()) {
    if (doubtful_names_ > 0) return nullptr;
    std::vector<std::string> fitting;  // only names of the needed dimension are proposed
    std::string list;
    for (const auto& [key, entry] : entries_) {
      if (entry.dimension == d) fitting.push_back(key);
      list += (list.empty() ? "" : ", ") + key;
    }
    const auto guess = or_comma(guess_words(nearest_key(name, fitting)));
    value.refuse(fmt::format("\"${}\" names no parameter or sweep variable known here{} known: {}",
                             printable(name), guess, list.empty() ? "none" : list));
    return nullptr;
  }
  if (!it->second.unit_known) return nullptr;
  if (it->second.dimension != d) {
    value.refuse(fmt::format("\"${}\" is {}, {}", name, dimension_words(name, it->second.dimension),
                             expected_dimension(d)));
    return nullptr;
  }
  return &it->second;
}

Number Scope::read(const JsonReader& value, Dimension d, double to_si, const Range& si) const {
  Number n;
  n.pointer = value.pointer();
  n.to_si = to_si;
  if (!value.is_string()) {
    n.value = value.number_in(to_si, si);
    return n;
  }
  if (const ScopeEntry* entry = find(value, d, n.name)) {
    for (const double bound : {entry->min, entry->max}) {
      if (!entry->bounded || contains(si, bound)) continue;
      value.refuse(fmt::format("\"${}\" may be {:.6g}, expected {}", n.name, bound / to_si,
                               range_words(si, to_si)));
    }
  }
  return n;
}

Number Scope::read_count(const JsonReader& value, std::int64_t min, std::int64_t max) const {
  Number n;
  n.pointer = value.pointer();
  if (!value.is_string()) {
    n.value = static_cast<double>(value.integer(min, max));
    return n;
  }
  const Range range{static_cast<double>(min), static_cast<double>(max)};
  n = read(value, Dimension::none, 1, range);
  const auto it = entries_.find(n.name);
  if (it != entries_.end() && it->second.bounded && !it->second.integer) {
    value.refuse(
        fmt::format("\"${}\" may be a fraction, expected a whole number: give the "
                    "parameter \"integer\": true",
                    n.name));
  }
  return n;
}

std::optional<Number> Scope::optional(const JsonReader& object, std::string_view stem, Dimension d,
                                      const Range& si) const {
  const auto field = object.find_quantity(stem, d);
  if (!field) return std::nullopt;
  return read(field->value, d, field->unit.to_si, si);
}

Number Scope::required(const JsonReader& object, std::string_view stem, Dimension d,
                       const Range& si) const {
  if (auto n = optional(object, stem, d, si)) return *n;
  static_cast<void>(object.quantity(stem, d));  // refuses the object with the right words
  return {};
}

ScopeEntry Scope::bounds(const Number& n, Dimension d) const {
  const auto it = entries_.find(n.name);
  if (it != entries_.end()) return it->second;
  ScopeEntry entry;
  entry.dimension = d;
  entry.min = entry.max = n.value;
  return entry;
}

}  // namespace lcrig
