// SPDX-License-Identifier: Apache-2.0
// A byte stream from the gateway. Property: the lines do not depend on how the bytes arrive, and
// every line is either refused or written back as it was.
#include <algorithm>
#include <cmath>

#include "drivers/zwick/codec.hpp"
#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {

namespace {

using namespace frame_link;

constexpr double kSane = 1e6;  // a larger value in mm loses digits on the grid of 1 pm

std::vector<std::string> lines_of(std::string_view bytes, std::size_t piece) {
  LineSplitter splitter;
  std::vector<std::string> out;
  while (!bytes.empty()) {
    splitter.feed(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    while (const auto line = splitter.next()) out.emplace_back(*line);
  }
  return out;
}

Line parsed(std::string_view text) {
  auto line = parse_line(text.substr(0, text.size() - 1));  // without LF
  require(line.has_value(), "our own line is refused: " + std::string(text));
  return std::move(*line);
}

void read_hello(const Line& line) {
  const auto hello = parse_hello(line);
  if (!hello) return require_good_message(hello.error());
  const std::string text = format_hello(*hello);
  const auto again = parse_hello(parsed(text));
  require(again && format_hello(*again) == text, "HELLO changed: " + text);
}

void read_caps(const Line& line) {
  const auto caps = parse_caps(line);
  if (!caps) return require_good_message(caps.error());
  const double most =
      std::max({caps->force_max.si(), caps->speed_max.si(), std::abs(caps->travel_min.si()),
                std::abs(caps->travel_max.si()), caps->deceleration.si()});
  require(std::isfinite(most) && std::isfinite(caps->sample_rate_max_Hz), "CAPS not finite");
  if (most > kSane) return;
  const std::string text = format_caps(*caps);
  // The grid of 1 pm may make a tiny range empty. Written a second time, the text must not change.
  if (const auto again = parse_caps(parsed(text))) {
    require(format_caps(*again) == text, "CAPS changed: " + text);
  }
}

void read_limits(const Line& line) {
  const auto limits = parse_limits(line);
  if (!limits) return require_good_message(limits.error());
  if (std::max({std::abs(limits->travel_min.si()), std::abs(limits->travel_max.si()),
                std::abs(limits->speed_max.si())}) > kSane) {
    return;
  }
  const std::string text = format_limits(1, *limits);
  const auto again = parse_limits(parsed(text));
  require(again && format_limits(1, *again) == text, "LIMITS changed: " + text);
}

bool is_sound(const std::optional<double>& value) {
  return !value || std::isfinite(*value);
}

void read_samples(const Line& line) {
  std::vector<FrameSample> samples;
  const auto read = parse_samples(line, samples);
  if (!read) {
    require(samples.empty(), "samples of a refused line");
    return require_good_message(read.error());
  }
  bool sane = true;
  for (const FrameSample& s : samples) {
    require(is_sound(s.force_N) && is_sound(s.travel_m) && is_sound(s.device_time_s),
            "a sample that is not finite");
    sane = sane && std::abs(s.travel_m.value_or(0)) < kSane;
  }
  if (!sane) return;
  std::string text, twice;
  append_samples(text, samples);
  if (text.size() > kMaxLine) return;
  std::vector<FrameSample> again;
  require(parse_samples(parsed(text), again).has_value(), "our own samples are refused: " + text);
  append_samples(twice, again);
  require(twice == text, "samples changed: " + text);
}

void read_done(const Line& line) {
  const MotionOutcome done = parse_done(line);
  require(is_sound(done.force_N) && is_sound(done.travel_m), "DONE not finite");
}

void read_line(std::string_view text) {
  const auto line = parse_line(text);
  if (!line) return require_good_message(line.error());
  require(!line->word.empty(), "a line without a word");
  read_hello(*line);
  read_caps(*line);
  read_limits(*line);
  read_samples(*line);
  read_done(*line);
  if (const auto travel = length_of(*line, "travel_mm"); !travel) {
    require_good_message(travel.error());
  }
}

}  // namespace

// The first byte is the size of the pieces, minus one.
void read_frame_link(std::string_view input) {
  if (input.empty()) return;
  const std::size_t piece = 1 + static_cast<unsigned char>(input.front());
  input.remove_prefix(1);
  const auto lines = lines_of(input, input.size() + 1);
  require(lines_of(input, piece) == lines, "the lines depend on how they arrive");
  for (const auto& line : lines) read_line(line);
}

}  // namespace lcrig::fuzz
