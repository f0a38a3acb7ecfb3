// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/key_words.hpp"
#include "base/text.hpp"
#include "protocols/file/step_reader.hpp"

namespace lcrig {

namespace {

constexpr std::int64_t kSweepValuesMax = 10'000;

// Fills `values`, or `from`, `to` and `count` if one of them is a reference.
ScopeEntry sweep_values(const StepReader& r, const KeyParts& key, SweepStep& out) {
  ScopeEntry entry;
  entry.dimension = key.dimension();
  const auto read = [&](const JsonReader& v) {
    return r.scope.read(v, key.dimension(), key.to_si(), kAnyNumber);
  };
  if (const auto values = r.json.find("values")) {
    for (const JsonReader& v : values->items(1, kSweepValuesMax)) out.values.push_back(read(v));
    if (r.json.has("from") || r.json.has("to") || r.json.has("count")) {
      r.json.refuse("values and from/to/count, expected only one way to give them");
    }
  } else {
    out.from = read(r.json.at("from"));
    out.to = read(r.json.at("to"));
    out.count = r.count("count", 2, kSweepValuesMax);
  }
  std::vector<Number> all = out.values;
  if (out.from) all.insert(all.end(), {*out.from, *out.to});
  for (std::size_t i = 0; i < all.size(); ++i) {
    const ScopeEntry b = r.scope.bounds(all[i], key.dimension());
    entry.min = i == 0 ? b.min : std::min(entry.min, b.min);
    entry.max = i == 0 ? b.max : std::max(entry.max, b.max);
    entry.bounded = entry.bounded && b.bounded;
  }
  return entry;
}

}  // namespace

SweepStep SweepStep::parse(const StepReader& r) {
  SweepStep out;
  const JsonReader name = r.json.at("name");
  out.name = name.nonempty_string(64);
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  if (!std::ranges::all_of(out.name, good)) {
    name.refuse(fmt::format("\"{}\", expected letters, digits and _ only", printable(out.name)));
  }
  if (const auto unit = name_unit_mistake(out.name)) name.refuse(*unit);
  if (r.scope.has(out.name)) {
    name.refuse(
        fmt::format("\"{}\" is already a parameter or the variable of a sweep around this "
                    "one, expected a new name",
                    out.name));
  }
  const KeyParts key = split_key(out.name);
  // Without its name the unit of the values is unknown.
  const bool named = name.sound();
  ScopeEntry entry;
  if (named) {
    entry = sweep_values(r, key, out);
  } else {
    for (const char* known : {"values", "from", "to", "count"}) r.json.has(known);
  }
  const auto whole = [](const Number& n) {
    return n.name.empty() && n.value == std::floor(n.value);
  };
  entry.integer = !key.unit && !out.values.empty() && std::ranges::all_of(out.values, whole);
  entry.bounded = entry.bounded && r.json.sound();
  // While the name is wrong, no reference inside can be judged.
  if (named) r.scope.add(out.name, entry);
  if (!named) r.scope.set_names_doubtful(true);
  out.steps = r.steps();
  if (named) r.scope.remove(out.name);
  if (!named) r.scope.set_names_doubtful(false);
  return out;
}

std::int64_t SweepStep::passes(const Environment& env) const {
  return count ? std::llround(env.get(*count)) : std::ssize(values);
}

std::vector<const Number*> SweepStep::ends() const {
  std::vector<const Number*> out;
  for (const Number& value : values) out.push_back(&value);
  if (count) out.insert(out.end(), {&*from, &*to});
  return out;
}

void SweepStep::set_variable(std::int64_t pass, Environment& env) const {
  if (!count) return env.set(name, env.get(values.at(static_cast<std::size_t>(pass - 1))));
  const double first = env.get(*from), end = env.get(*to), last = env.get(*count) - 1;
  const auto i = static_cast<double>(pass - 1);
  env.set(name, i >= last ? end : first + (end - first) * (i / last));  // `end` exactly at last
}

}  // namespace lcrig
