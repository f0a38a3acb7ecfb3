// SPDX-License-Identifier: Apache-2.0
// The sample line, whose fields are columns of n values.
#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

#include "base/number.hpp"
#include "drivers/zwick/codec.hpp"
#include "drivers/zwick/millimetres.hpp"

namespace lcrig::frame_link {

namespace {

// Appends a column of a sample line: n values separated by commas. A missing value is empty.
template <class Get>
void append_column(std::string& out, std::string_view key, std::span<const FrameSample> samples,
                   Get get) {
  const auto has = [&](const FrameSample& s) { return get(s).has_value(); };
  if (std::ranges::none_of(samples, has)) return;
  out.append(" ").append(key);
  char separator = '=';
  for (const auto& s : samples) {
    out += std::exchange(separator, ',');
    if (const auto value = get(s)) append_number(out, *value);
  }
}

constexpr std::array<std::pair<char, std::uint32_t>, 3> kFlags{{
    {'M', frame_flag::kMoving},
    {'F', frame_flag::kForceControl},
    {'O', frame_flag::kForceOverload},
}};

void append_flag_word(std::string& out, std::uint32_t flags) {
  const auto before = out.size();
  for (const auto& [letter, bit] : kFlags) {
    if ((flags & bit) != 0) out += letter;
  }
  if (out.size() == before) out += '-';
}

void append_flags(std::string& out, std::span<const FrameSample> samples) {
  const auto same = [&](const FrameSample& s) { return s.flags == samples[0].flags; };
  const bool one = std::ranges::all_of(samples, same);
  out += " flags=";
  append_flag_word(out, samples[0].flags);
  if (one) return;
  for (const auto& s : samples.subspan(1)) {
    out += ',';
    append_flag_word(out, s.flags);
  }
}

// Unknown letters are ignored, as unknown fields are.
std::uint32_t parse_flag_word(std::string_view word) {
  std::uint32_t flags = 0;
  for (const auto& [letter, bit] : kFlags) {
    if (word.find(letter) != std::string_view::npos) flags |= bit;
  }
  return flags;
}

std::string_view take_cell(std::string_view& column) {
  const auto end = std::min(column.find(','), column.size());
  const auto cell = column.substr(0, end);
  column.remove_prefix(std::min(end + 1, column.size()));
  return cell;
}

std::size_t cells(std::string_view column) {
  return 1 + static_cast<std::size_t>(std::ranges::count(column, ','));
}

template <class Set>
Result<> parse_column(const Line& line, std::string_view key, std::span<FrameSample> samples,
                      Set set) {
  auto column = line.find(key);
  if (!column) return {};
  if (cells(*column) != samples.size()) {
    return fail(Errc::garbled, "S: {} has {} values, n={}", key, cells(*column), samples.size());
  }
  for (auto& s : samples) {
    const auto cell = take_cell(*column);
    if (cell.empty()) continue;
    const auto value = parse_number(cell);
    if (!value) return fail(Errc::garbled, "S: {}: {}", key, value.error().what);
    set(s, *value);
  }
  return {};
}

Result<> parse_flags(const Line& line, std::span<FrameSample> samples) {
  auto column = line.find("flags");
  if (!column) return {};
  const auto n = cells(*column);
  if (n != 1 && n != samples.size()) {
    return fail(Errc::garbled, "S: flags has {} values, n={}", n, samples.size());
  }
  const bool one = n == 1;
  const auto all = one ? parse_flag_word(*column) : 0;
  for (auto& s : samples) s.flags = one ? all : parse_flag_word(take_cell(*column));
  return {};
}

Result<> parse_columns(const Line& line, std::span<FrameSample> samples) {
  auto r = parse_column(line, "t_s", samples, [](auto& s, double v) { s.device_time_s = v; });
  if (!r) return r;
  r = parse_column(line, "force_N", samples, [](auto& s, double v) { s.force_N = v; });
  if (!r) return r;
  r = parse_column(line, "travel_mm", samples, [](auto& s, double v) { s.travel_m = from_mm(v); });
  if (!r) return r;
  return parse_flags(line, samples);
}

}  // namespace

void append_samples(std::string& out, std::span<const FrameSample> samples) {
  assert(!samples.empty());
  out += "S seq=";
  append_integer(out, samples[0].device_seq);
  out += " n=";
  append_integer(out, static_cast<std::int64_t>(samples.size()));
  append_column(out, "t_s", samples, [](const auto& s) { return s.device_time_s; });
  append_column(out, "force_N", samples, [](const auto& s) { return s.force_N; });
  append_column(out, "travel_mm", samples, [](const auto& s) { return to_mm(s.travel_m); });
  append_flags(out, samples);
  out += '\n';
}

Result<> parse_samples(const Line& line, std::vector<FrameSample>& out) {
  const auto seq = number_from<std::int64_t>(line.find("seq").value_or(std::string_view()));
  const auto n = number_from<std::int64_t>(line.find("n").value_or(std::string_view()));
  constexpr std::int64_t kMaxSamples = 10'000;  // more do not fit into a line
  constexpr std::int64_t kMaxSeq = std::numeric_limits<std::int64_t>::max() - kMaxSamples;
  if (!seq || *seq < 0 || *seq > kMaxSeq || !n || *n < 1 || *n > kMaxSamples) {
    return fail(Errc::garbled, "S without a usable seq and n");
  }
  const auto before = out.size();
  out.resize(before + static_cast<std::size_t>(*n));
  const auto samples = std::span(out).subspan(before);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].device_seq = *seq + static_cast<std::int64_t>(i);
  }
  auto parsed = parse_columns(line, samples);
  if (!parsed) out.resize(before);
  return parsed;
}

}  // namespace lcrig::frame_link
