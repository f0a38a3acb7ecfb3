// SPDX-License-Identifier: Apache-2.0
#include "base/near_word.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kLongestWord = 64;  // longer words are not compared; this bounds the table

// Optimal string alignment: insertions, deletions, changes and swaps of neighbours cost one each.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

// "Cp-D" is "Cp" and "D", "paper-12" is "paper" and "12".
std::vector<std::string_view> parts_of(std::string_view word) {
  enum class Kind { mark, digit, letter };
  const auto kind = [](char letter) {
    const auto c = static_cast<unsigned char>(letter);
    if (c == '-' || c == '_' || c == '.' || c == ' ') return Kind::mark;
    return std::isdigit(c) != 0 ? Kind::digit : Kind::letter;
  };
  std::vector<std::string_view> out;
  for (std::size_t begin = 0, end = 0; begin < word.size(); begin = end) {
    for (end = begin; end < word.size() && kind(word[end]) == kind(word[begin]);) ++end;
    if (kind(word[begin]) != Kind::mark) out.push_back(word.substr(begin, end - begin));
  }
  return out;
}

// True when some part has no letter in common with its counterpart. Such a part was meant: Cp-Q is
// not a slip for Cp-D, nor paper-9 for paper-1.
bool is_another(std::string_view a, std::string_view b) {
  const auto left = parts_of(a), right = parts_of(b);
  if (left.size() < 2 || left.size() != right.size()) return false;
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left[i].find_first_of(right[i]) == left[i].npos) return true;
  }
  return false;
}

std::string words_of_guess(std::span<const std::string> words, const GuessStyle& style) {
  const auto best = alternatives(words, style.quote);
  return best.empty() ? best : fmt::format("{}did you mean {}?", style.lead, best);
}

}  // namespace

std::vector<std::string> nearest_words(std::string_view word, std::span<const std::string> known) {
  std::vector<std::string> best;
  if (word.empty() || word.size() > kLongestWord) return best;
  const std::string typed = lower_case(word);
  // At least one letter must be left of the typed word.
  std::size_t nearest = std::min(std::max<std::size_t>(1, word.size() / 3), word.size() - 1);
  for (const std::string& candidate : known) {
    if (candidate.size() > 2 * kLongestWord || is_another(typed, lower_case(candidate))) continue;
    const bool begins = word.size() >= 3 && candidate.starts_with(word);
    const std::size_t distance = begins ? 1 : edit_distance(typed, lower_case(candidate));
    if (distance > nearest) continue;
    if (distance < nearest) best.clear();
    nearest = distance;
    if (std::ranges::find(best, candidate) == best.end()) best.push_back(candidate);
  }
  return best;
}

std::optional<std::string> nearest_word(std::string_view word, std::span<const std::string> known) {
  auto best = nearest_words(word, known);
  if (best.size() != 1) return std::nullopt;
  return std::move(best.front());
}

std::string alternatives(std::span<const std::string> words, char quote) {
  const auto quoted = [quote](const std::string& word) {
    return fmt::format("{}{}{}", quote, printable(word), quote);
  };
  if (words.size() == 1) return quoted(words[0]);
  return words.size() == 2 ? quoted(words[0]) + " or " + quoted(words[1]) : std::string();
}

std::string did_you_mean(std::string_view word, std::span<const std::string> known,
                         const GuessStyle& style) {
  return words_of_guess(nearest_words(word, known), style);
}

std::string guess_words(const std::optional<std::string>& meant, const GuessStyle& style) {
  return meant ? words_of_guess(std::span(&*meant, 1), style) : std::string();
}

std::string or_comma(std::string guess) {
  return guess.empty() ? "," : guess;
}

}  // namespace lcrig
