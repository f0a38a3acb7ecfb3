// SPDX-License-Identifier: Apache-2.0
#include "analysis/device_clock.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "analysis/pieces.hpp"

namespace lcrig {

namespace {

constexpr std::int64_t kStretchRows = 256;  // some seconds: among many batches one was quick
constexpr std::int64_t kMostStretches = 512;
constexpr double kPiece_s = 600;  // within it a crystal in a room drifts by microseconds
constexpr std::size_t kLeastOfPiece = 4;  // fewest stretches of a piece
constexpr double kForRate_s = 30;  // in less time, jitter would be taken for a rate
constexpr double kWorstRate = 0.01;  // a rate beyond that of any crystal
constexpr double kJump_s = 0.05;
constexpr double kBelieved = 0.05, kBelieved_s = 0.5;  // tolerance: relative, and for lateness
constexpr double kMostLate_s = 10;

// A series of samples that arrived one after another.
struct ClockStretch {
  std::int64_t first_ns = 0, last_ns = 0;  // arrival
  std::optional<double> first_device_s, last_device_s;
  std::int64_t quickest_ns = 0, delay_ns = 0;  // of the quickest; delay: arrival less device time
  bool believed() const {
    if (!first_device_s) return false;
    const double host_s = static_cast<double>(last_ns - first_ns) * 1e-9;
    return std::abs(*last_device_s - *first_device_s - host_s) <= kBelieved * host_s + kBelieved_s;
  }
};

std::int64_t ns_of(double device_time_s) {
  return static_cast<std::int64_t>(std::llround(device_time_s * 1e9));
}

void add(ClockStretch& s, std::int64_t received_ns, std::optional<double> device_time_s) {
  s.last_ns = received_ns;
  if (!device_time_s) return;
  const std::int64_t delay_ns = received_ns - ns_of(*device_time_s);
  if (!s.first_device_s) s.first_device_s = device_time_s;
  if (!s.last_device_s || delay_ns < s.delay_ns) {
    s.delay_ns = delay_ns;
    s.quickest_ns = received_ns;
  }
  s.last_device_s = device_time_s;
}

Result<std::vector<ClockStretch>> read_stretches(const Database& db, std::int64_t run) {
  const auto last = last_seq(db, "frame_sample", run);
  if (!last) return fail(last.error());
  std::vector<ClockStretch> out;
  const std::int64_t step = std::max(kStretchRows, *last / kMostStretches);
  for (std::int64_t seq = 1; seq <= *last; seq += step) {
    ClockStretch s;
    bool any = false;
    const auto take = [&](const Statement& row) {
      if (!std::exchange(any, true)) s.first_ns = row.integer(0);
      add(s, row.integer(0), row.optional_real(1));
    };
    auto all = db.each(
        "SELECT received_mono_ns, device_time_s FROM frame_sample WHERE run_id = ?"
        " AND seq BETWEEN ? AND ? ORDER BY seq",
        take, run, seq, seq + kStretchRows - 1);
    if (!all) return fail(all.error());
    if (any) out.push_back(s);
  }
  return out;
}

bool jumps(const ClockStretch& a, const ClockStretch& b) {
  const double apart_s = static_cast<double>(b.quickest_ns - a.quickest_ns) * 1e-9;
  const double change_s = static_cast<double>(b.delay_ns - a.delay_ns) * 1e-9;
  return std::abs(change_s) > kWorstRate * apart_s + kJump_s;
}

struct DelayLine {
  double height = 0, rate = 0;
};

// Among all lines that lie below all points, finds the one that is highest in the middle (Moon,
// Skelly and Towsley, "Estimation and removal of clock skew", INFOCOM 1999).
DelayLine lower_line(const std::vector<double>& x, const std::vector<double>& y) {
  DelayLine best{*std::ranges::min_element(y), 0};
  const double middle = x.back() / 2;
  double highest = best.height;
  for (std::size_t i = 0; x.back() >= kForRate_s && i < x.size(); ++i) {
    for (std::size_t j = i + 1; j < x.size(); ++j) {
      const double rate = (y[j] - y[i]) / (x[j] - x[i]);
      const DelayLine line{y[i] - rate * x[i], rate};
      const double at_middle = line.height + rate * middle;
      bool below = at_middle > highest && std::abs(rate) <= kWorstRate;
      for (std::size_t k = 0; k < x.size() && below; ++k) {
        below = k == i || k == j || y[k] >= line.height + rate * x[k];
      }
      if (below) best = line, highest = at_middle;
    }
  }
  return best;
}

DeviceClock::Piece piece_of(std::span<const ClockStretch> stretches) {
  const ClockStretch& first = stretches.front();
  DeviceClock::Piece out;
  out.from_ns = first.first_ns;
  out.known = first.believed();
  if (!out.known) return out;
  std::vector<double> x, y;  // s; x: arrival since the first, y: delay beyond that of the first
  for (const ClockStretch& s : stretches) {
    x.push_back(static_cast<double>(s.quickest_ns - first.first_ns) * 1e-9);
    y.push_back(static_cast<double>(s.delay_ns - first.delay_ns) * 1e-9);
  }
  const DelayLine line = lower_line(x, y);
  out.offset_ns = first.delay_ns + std::llround(line.height * 1e9);
  out.rate = line.rate;
  double squares = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double rest = y[i] - line.height - line.rate * x[i];
    squares += rest * rest / static_cast<double>(x.size());
  }
  out.residual_s = std::sqrt(squares);
  return out;
}

}  // namespace

Result<DeviceClock> DeviceClock::fit(const Database& db, std::int64_t run) {
  const auto all = read_stretches(db, run);
  if (!all) return fail(all.error());
  DeviceClock out;
  for (std::size_t begin = 0, end = 0; begin < all->size(); begin = end) {
    const auto& s = *all;
    for (end = begin + 1; end < s.size(); ++end) {
      if (s[end].believed() != s[begin].believed()) break;
      if (s[begin].believed() && jumps(s[end - 1], s[end])) break;
    }
    const double span_s = static_cast<double>(s[end - 1].last_ns - s[begin].first_ns) * 1e-9;
    const std::size_t count = end - begin;
    const auto parts = std::clamp<std::size_t>(static_cast<std::size_t>(span_s / kPiece_s), 1,
                                               std::max<std::size_t>(1, count / kLeastOfPiece));
    for (std::size_t k = 0; k < parts; ++k) {
      const std::size_t from = count * k / parts, to = count * (k + 1) / parts;
      out.pieces_.push_back(piece_of(std::span(s).subspan(begin + from, to - from)));
    }
  }
  return out;
}

DeviceClock::Time DeviceClock::at(std::int64_t received_ns,
                                  std::optional<double> device_time_s) const {
  if (!device_time_s || pieces_.empty()) return {received_ns};
  const auto after = std::ranges::upper_bound(pieces_, received_ns, {}, &Piece::from_ns);
  const Piece& piece = after == pieces_.begin() ? pieces_.front() : *(after - 1);
  if (!piece.known) return {received_ns};
  const std::int64_t rough_ns = ns_of(*device_time_s) + piece.offset_ns;
  const std::int64_t gained_ns =
      std::llround(piece.rate * static_cast<double>(rough_ns - piece.from_ns));
  const double late_s = static_cast<double>(received_ns - rough_ns - gained_ns) * 1e-9;
  if (late_s > kMostLate_s || late_s < -kJump_s) return {received_ns};
  return {std::min(received_ns, rough_ns + gained_ns), false, piece.residual_s};
}

}  // namespace lcrig
