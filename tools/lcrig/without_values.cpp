// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/without_values.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
namespace lcrig::cli {

using nlohmann::json;

namespace {

bool is_of_name(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

// Bytes of the number that `rest` begins with (12, 3.0110, 1,024, 2e-9); 0: there is none.
std::size_t length_of_number(std::string_view rest) {
  std::size_t n = 0;
  while (n < rest.size()) {
    const char c = rest[n];
    const bool goes_on = n + 1 < rest.size() && is_digit(rest[n + 1]);
    const bool signed_power =
        n + 2 < rest.size() && (rest[n + 1] == '-' || rest[n + 1] == '+') && is_digit(rest[n + 2]);
    if (is_digit(c) || ((c == '.' || c == ',') && goes_on)) {
      ++n;
    } else if ((c == 'e' || c == 'E') && (goes_on || signed_power)) {
      n += 2;
    } else {
      break;
    }
  }
  return n;
}

bool counts_runs(std::string_view before) {
  constexpr std::array<std::string_view, 2> kWords{"run ", "entry "};
  return std::ranges::any_of(kWords, [&](std::string_view word) {
    if (!before.ends_with(word)) return false;
    before.remove_suffix(word.size());
    return before.empty() || !is_of_name(before.back());
  });
}

}  // namespace

std::string without_numbers(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const bool in_name = i > 0 && is_of_name(text[i - 1]);
    if (!is_digit(text[i]) || in_name) {
      out += text[i++];
      continue;
    }
    const std::size_t length = length_of_number(text.substr(i));
    const auto number = text.substr(i, length);
    const bool whole = std::ranges::all_of(number, is_digit);
    if (whole && counts_runs(text.substr(0, i))) {
      out += number;
    } else {
      out += '#';
    }
    i += length;
  }
  return out;
}

std::string journal_without_numbers(std::string_view journal) {
  std::string out;
  out.reserve(journal.size());
  while (!journal.empty()) {
    const auto end = journal.find('\n');
    const auto line = journal.substr(0, end);
    constexpr std::string_view kProcess = "]: ";
    const auto head = line.find(kProcess);
    const auto kept = head == std::string_view::npos ? 0 : head + kProcess.size();
    out += line.substr(0, kept);
    out += without_numbers(line.substr(kept));
    if (end == std::string_view::npos) break;
    out += '\n';
    journal.remove_prefix(end + 1);
  }
  return out;
}

json status_without_values(json status) {
  if (!status.is_structured()) return status;
  if (status.is_object()) {
    for (const char* measured :
         {"capacitance_pF", "secondary", "force_N", "travel_mm", "gap_mm", "pressure_kPa"}) {
      status.erase(measured);
    }
    for (const char* words : {"reason", "why", "prompt", "text", "detail"}) {
      const auto told = status.find(words);
      if (told == status.end() || !told->is_string()) continue;
      *told = without_numbers(told->get_ref<const std::string&>());
    }
  }
  for (auto& part : status) part = status_without_values(std::move(part));
  return status;
}

}  // namespace lcrig::cli
