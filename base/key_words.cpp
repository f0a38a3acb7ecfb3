// SPDX-License-Identifier: Apache-2.0
#include "base/key_words.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <vector>

#include "base/near_word.hpp"
#include "base/text.hpp"
#include "base/units.hpp"

namespace lcrig {

namespace {

std::string_view suffix_of(std::string_view key) {
  const KeyParts parts = split_key(key);
  return parts.dimension() == Dimension::none ? std::string_view() : parts.unit->suffix;
}

std::string without_marks(std::string_view key) {
  std::string out;
  std::ranges::copy_if(key, std::back_inserter(out),
                       [](char c) { return c != '_' && c != '-' && c != ' '; });
  return out;
}

// True for "rateHz" and "RATE-HZ" when "rate_Hz" is known. Letter case counts in the unit, where m
// is milli and M is mega.
bool has_letters_of(std::string_view key, std::string_view known) {
  const std::string typed = without_marks(key), meant = without_marks(known);
  if (typed.size() != meant.size()) return false;
  const std::size_t unit_at = meant.size() - without_marks(suffix_of(known)).size();
  for (std::size_t i = 0; i < meant.size(); ++i) {
    const auto a = static_cast<unsigned char>(typed[i]), b = static_cast<unsigned char>(meant[i]);
    if (std::tolower(a) != std::tolower(b)) return false;
    if (a != b && i >= unit_at && std::tolower(b) == 'm') return false;
  }
  return true;
}

// The known stem that `key` begins with, or that it mistypes. To be asked when `key` has no known
// unit.
std::optional<std::string> stem_of(std::string_view key, const std::vector<std::string>& stems) {
  const std::string* longest = nullptr;
  for (const std::string& stem : stems) {
    if (!key.starts_with(stem)) continue;
    if (key.size() > stem.size() && key[stem.size()] != '_') continue;
    if (longest == nullptr || stem.size() > longest->size()) longest = &stem;
  }
  if (longest != nullptr) return *longest;
  return suffix_of(key).empty() ? nearest_word(key, stems) : std::nullopt;
}

}  // namespace

std::optional<std::string> nearest_key(std::string_view key, std::span<const std::string> known) {
  for (const std::string& candidate : known) {
    if (has_letters_of(key, candidate)) return candidate;
  }
  std::vector<std::string> same_unit;
  for (const std::string& candidate : known) {
    const auto suffix = suffix_of(candidate);
    if (suffix.empty() || suffix == suffix_of(key)) same_unit.push_back(candidate);
  }
  return nearest_word(key, same_unit);
}

std::optional<std::string> unit_mistake(std::string_view key, std::span<const std::string> known) {
  if (nearest_key(key, known)) return std::nullopt;
  std::vector<std::string> stems;
  for (const std::string& candidate : known) {
    if (!suffix_of(candidate).empty()) stems.emplace_back(split_key(candidate).stem);
  }
  const auto stem = stem_of(key, stems);
  if (!stem) return std::nullopt;
  std::string takes;
  Dimension dimension = Dimension::none;
  for (const std::string& candidate : known) {
    const KeyParts parts = split_key(candidate);
    if (parts.stem != *stem || suffix_of(candidate).empty()) continue;
    if ((takes + ",").find(candidate + ",") != takes.npos) continue;  // already listed
    takes += (takes.empty() ? "" : ", ") + candidate;
    dimension = parts.dimension();
  }
  const std::string shown = printable(key, 60);
  if (key == *stem) return fmt::format("`{}` has no unit; it takes {}", shown, takes);
  if (!key.starts_with(*stem)) {
    return fmt::format("unknown key `{}`{} With its unit it is {}", shown, guess_words(stem),
                       takes);
  }
  const auto suffix = key.substr(stem->size());
  const Unit* unit = find_unit(suffix.substr(1));
  if (unit != nullptr && unit->dimension == dimension) {
    return fmt::format("`{}`: `{}` is not known here; it takes {}", shown, suffix, takes);
  }
  return fmt::format("`{}`: `{}` is no unit of {}; it takes {}", shown, printable(suffix, 60),
                     to_string(dimension), takes);
}

std::optional<std::string> name_unit_mistake(std::string_view name) {
  const auto unknown = find_unknown_unit(name);
  if (!unknown) return std::nullopt;
  return fmt::format("`{}`: `_{}` is no unit of {} here; there are {}", printable(name, 60),
                     printable(unknown->suffix, 60), to_string(unknown->dimension),
                     suffixes_of(unknown->dimension));
}

}  // namespace lcrig
