// SPDX-License-Identifier: Apache-2.0
// Finds a sine in the readings that does not come from the specimen. See metrics.hpp.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

constexpr double kLowest_Hz = 0.05, kHighest_Hz = 1;
constexpr double kOversampling = 3;  // of the periodogram, over one point per period in the run
constexpr double kHumBlock_s = 0.25;  // in such a mean a sine of 1 Hz keeps 0.9 of its amplitude
constexpr double kReadingsAPeriod = 2.5;  // fewest readings in a period
constexpr double kFalseHum = 1e-3;  // share of runs without a sine in which one is found by mistake
constexpr std::size_t kBeside = 90, kOfSine = 5;  // on either side: of noise; of the sine itself
constexpr std::size_t kLeastFrequencies = 60;
constexpr std::size_t kLeastBlocks = 4;  // fewest blocks of a stretch
constexpr Eigen::Index kLeastAlike = 3, kLeastLevels = 4;  // fewest stretches that are compared
// Share of a sine that must remain after everything a specimen may do is taken out.
constexpr double kLeft = 0.05;
constexpr double kMostWork = 4e7;  // frequencies times blocks; takes a fifth of a second
constexpr int kRefinements = 3, kHalf = 4;  // steps on either side, each time a quarter as wide

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

// One stretch as the means of blocks of neighbouring readings.
struct HumStretch {
  std::vector<double> t_s, fF;
  double level_fF = 0;  // mean of the level; 0 for a rest
};

// Stretches of equal length. Their blocks follow each other in the vectors of HumSearch.
struct Alike {
  Eigen::Index first = 0, blocks = 0, stretches = 0;
  Matrix common;  // orthonormal, stretches by functions: what the k-th blocks may share
  Vector trend;  // the line of a single stretch, with unit length and mean 0; else empty
};

struct SineFit {
  double explained = 0;  // sum of squares; 0: the sine cannot be told from the specimen
  double cosine_fF = 0, sine_fF = 0;
};

class HumSearch {
 public:
  HumSearch(const RunView& view, const Rests& rests, const MeasuredLevels& measured,
            double block_s);

  Eigen::Index blocks() const { return t_s_.size(); }
  double begin_s() const { return t_s_.minCoeff(); }
  double length_s() const { return t_s_.maxCoeff() - t_s_.minCoeff(); }
  double block_s() const { return block_s_; }
  // Fits all frequencies from `low_Hz` on.
  std::vector<SineFit> fit_all(double low_Hz, double step_Hz, std::size_t count) const;
  SineFit fit(double frequency_Hz) const;

 private:
  template <class Used>
  HumStretch cut(std::size_t first, std::size_t last, Used used) const;
  void add_rests(const Rests& rests);
  void add_levels(const MeasuredLevels& measured, Direction direction);
  void add(std::vector<HumStretch> stretches, bool levels);
  void add_alone(const HumStretch& stretch);
  void append(const HumStretch& stretch, std::size_t blocks);
  void take_out(const Alike& group);
  void finish();
  SineFit solve(const Matrix& waves) const;

  const RunView& view_;
  double block_s_ = 0;
  std::size_t together_ = 1;  // readings in a block
  std::vector<double> times_, values_;
  std::vector<Alike> groups_;
  Vector t_s_, left_fF_;  // of the blocks; what no specimen explains
};

double interval_of(const RunView& view, const Rests& rests, const MeasuredLevels& measured) {
  const auto& all = view.data.readings;
  std::vector<double> intervals;
  const auto add = [&](std::size_t first, std::size_t last) {
    if (last >= first + 2) {
      intervals.push_back((all[last - 1].t_s - all[first].t_s) /
                          static_cast<double>(last - first - 1));
    }
  };
  for (const RestNode& n : rests.drift.nodes()) add(n.first, n.last);
  for (const MeasuredLevel& l : measured.levels) add(l.first, l.last);
  return intervals.empty() ? 0 : median(intervals);
}

HumSearch::HumSearch(const RunView& view, const Rests& rests, const MeasuredLevels& measured,
                     double block_s)
    : view_(view) {
  const double interval_s = interval_of(view, rests, measured);
  if (!(interval_s > 0)) return;
  together_ = static_cast<std::size_t>(std::max(1.0, std::floor(block_s / interval_s)));
  block_s_ = interval_s * static_cast<double>(together_);
  add_rests(rests);
  add_levels(measured, Direction::up);
  add_levels(measured, Direction::down);
  finish();
}

template <class Used>
HumStretch HumSearch::cut(std::size_t first, std::size_t last, Used used) const {
  HumStretch out;
  RunningMean t_s, fF;
  for (std::size_t i = first; i < last; ++i) {
    if (!used(i)) continue;
    t_s.add(view_.data.readings[i].t_s);
    fF.add(view_.data.readings[i].capacitance_F * 1e15);
    if (fF.count < static_cast<std::int64_t>(together_)) continue;
    out.t_s.push_back(t_s.mean);
    out.fF.push_back(fF.mean);
    t_s = {}, fF = {};
  }
  return out;
}

void HumSearch::add_rests(const Rests& rests) {
  std::vector<HumStretch> after_load;
  for (const RestNode& n : rests.drift.nodes()) {
    const bool before = rests.loadings.empty() || n.t_s < rests.loadings.front().begin_s;
    const auto used = [&](std::size_t i) {
      return view_.uses(view_.data.readings[i]) && (before || view_.is_at_rest(i));
    };
    HumStretch s = cut(n.first, n.last, used);
    if (before) {
      add_alone(s);
    } else {
      after_load.push_back(std::move(s));
    }
  }
  add(std::move(after_load), false);
}

void HumSearch::add_levels(const MeasuredLevels& measured, Direction direction) {
  std::vector<HumStretch> levels;
  for (const MeasuredLevel& l : measured.levels) {
    if (l.direction != direction) continue;
    const auto used = [&](std::size_t i) {
      const RunReading& r = view_.data.readings[i];
      return r.level == l.level && r.index > 0 && view_.uses(r);
    };
    levels.push_back(cut(l.first, l.last, used));
    levels.back().level_fF = l.mean_pF * 1e3;
  }
  add(std::move(levels), true);
}

// Stretches of different length are cut to a common number of blocks, which keeps most blocks.
std::size_t common_length(const std::vector<HumStretch>& stretches) {
  std::map<std::size_t, std::size_t, std::greater<>> counts;
  for (const HumStretch& s : stretches) ++counts[s.fF.size()];
  std::size_t best = 0, kept = 0, longer = 0;
  for (const auto& [blocks, count] : counts) {
    longer += count;
    if (blocks * longer > kept) best = blocks, kept = blocks * longer;
  }
  return best;
}

void HumSearch::append(const HumStretch& stretch, std::size_t blocks) {
  times_.insert(times_.end(), stretch.t_s.begin(),
                stretch.t_s.begin() + static_cast<std::ptrdiff_t>(blocks));
  values_.insert(values_.end(), stretch.fF.begin(),
                 stretch.fF.begin() + static_cast<std::ptrdiff_t>(blocks));
}

void HumSearch::add(std::vector<HumStretch> stretches, bool levels) {
  const std::size_t blocks = common_length(stretches);
  if (blocks < kLeastBlocks) return;
  std::erase_if(stretches, [blocks](const HumStretch& s) { return s.fF.size() < blocks; });
  Alike group;
  group.first = static_cast<Eigen::Index>(times_.size());
  group.blocks = static_cast<Eigen::Index>(blocks);
  group.stretches = std::ssize(stretches);
  if (group.stretches < (levels ? kLeastLevels : kLeastAlike)) return;
  Vector level(group.stretches);
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    append(stretches[i], blocks);
    level(static_cast<Eigen::Index>(i)) = stretches[i].level_fF;
  }
  level.array() -= level.mean();
  const bool proportional = levels && level.norm() > 0;
  group.common.resize(group.stretches, proportional ? 2 : 1);
  group.common.col(0).setConstant(1 / std::sqrt(static_cast<double>(group.stretches)));
  if (proportional) group.common.col(1) = level.normalized();
  groups_.push_back(std::move(group));
}

void HumSearch::add_alone(const HumStretch& stretch) {
  if (stretch.fF.size() < kLeastBlocks) return;
  Alike group;
  group.first = static_cast<Eigen::Index>(times_.size());
  group.blocks = std::ssize(stretch.fF);
  group.stretches = 1;
  append(stretch, stretch.fF.size());
  const Eigen::Map<const Vector> t_s(stretch.t_s.data(), group.blocks);
  group.trend = (t_s.array() - t_s.mean()).matrix().normalized();
  groups_.push_back(std::move(group));
}

// The projections are exact, because the stretches of a group have equal length.
void HumSearch::take_out(const Alike& g) {
  Eigen::Map<Matrix> part(left_fF_.data() + g.first, g.blocks, g.stretches);
  part.rowwise() -= part.colwise().mean().eval();
  if (g.common.size() > 0) part -= (part * g.common).eval() * g.common.transpose();
  if (g.trend.size() > 0) part -= g.trend * (g.trend.transpose() * part).eval();
}

void HumSearch::finish() {
  t_s_ = Eigen::Map<const Vector>(times_.data(), std::ssize(times_));
  left_fF_ = Eigen::Map<const Vector>(values_.data(), std::ssize(values_));
  for (const Alike& g : groups_) take_out(g);
}

// Least squares of cosine and sine, which lose the same parts that were taken out of the readings.
SineFit HumSearch::solve(const Matrix& waves) const {
  Eigen::Matrix2d normal = waves.transpose() * waves;
  const Eigen::Vector2d right = waves.transpose() * left_fF_;
  for (const Alike& g : groups_) {
    Eigen::Matrix<double, Eigen::Dynamic, 2> sums(g.stretches, 2), common(g.blocks, 2);
    for (int k = 0; k < 2; ++k) {
      const Eigen::Map<const Matrix> part(waves.col(k).data() + g.first, g.blocks, g.stretches);
      sums.col(k) = part.colwise().sum().transpose();
    }
    normal -= sums.transpose() * sums / static_cast<double>(g.blocks);
    for (Eigen::Index c = 0; c < g.common.cols(); ++c) {
      for (int k = 0; k < 2; ++k) {
        const Eigen::Map<const Matrix> part(waves.col(k).data() + g.first, g.blocks, g.stretches);
        common.col(k).noalias() = part * g.common.col(c);
      }
      common.rowwise() -= common.colwise().mean().eval();
      normal -= common.transpose() * common;
    }
    if (g.trend.size() > 0) {
      const Eigen::RowVector2d along = g.trend.transpose() * waves.middleRows(g.first, g.blocks);
      normal -= along.transpose() * along;
    }
  }
  const double half = normal.trace() / 2, determinant = normal.determinant();
  const double smaller = half - std::sqrt(std::max(0.0, half * half - determinant));
  if (smaller < kLeft * static_cast<double>(blocks()) / 2) return {};
  const Eigen::Vector2d size = normal.inverse() * right;
  return {size.dot(right), size(0), size(1)};
}

SineFit HumSearch::fit(double frequency_Hz) const {
  const Eigen::ArrayXd phase = 2 * std::numbers::pi * frequency_Hz * t_s_.array();
  Matrix waves(blocks(), 2);
  waves.col(0) = phase.cos().matrix();
  waves.col(1) = phase.sin().matrix();
  return solve(waves);
}

// The waves of a frequency are those of the one before, rotated by one step.
std::vector<SineFit> HumSearch::fit_all(double low_Hz, double step_Hz, std::size_t count) const {
  const Eigen::ArrayXd begin = 2 * std::numbers::pi * low_Hz * t_s_.array();
  const Eigen::ArrayXd step = 2 * std::numbers::pi * step_Hz * t_s_.array();
  const Eigen::ArrayXd turn_cos = step.cos(), turn_sin = step.sin();
  Matrix waves(blocks(), 2);
  waves.col(0) = begin.cos().matrix();
  waves.col(1) = begin.sin().matrix();
  Eigen::ArrayXd next(blocks());
  std::vector<SineFit> out;
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(solve(waves));
    next = waves.col(0).array() * turn_cos - waves.col(1).array() * turn_sin;
    waves.col(1) = (waves.col(0).array() * turn_sin + waves.col(1).array() * turn_cos).matrix();
    waves.col(0) = next.matrix();
  }
  return out;
}

// Estimates the noise at a frequency from what sines at neighbouring frequencies explain. Under
// white noise a sine explains two mean squares. The median is then 2 ln 2 mean squares, and the
// mean logarithm lies Euler's constant below. Slow noise grows towards low frequencies, so a
// straight line through the logarithms is used where it gives more than the median.
double noise_at(const std::vector<SineFit>& fits, std::size_t at, double first) {
  std::vector<double> beside;
  RunningLine line;
  const auto place = [first](std::size_t i) { return std::log(first + static_cast<double>(i)); };
  const std::size_t end = std::min(fits.size(), at + kBeside + 1);
  for (std::size_t i = at - std::min(at, kBeside); i < end; ++i) {
    const bool own = i + kOfSine >= at && i <= at + kOfSine;
    if (own || !(fits[i].explained > 0)) continue;
    beside.push_back(fits[i].explained);
    line.add(place(i), std::log(fits[i].explained));
  }
  if (beside.size() < kBeside / 2) return 0;
  const double log = line.y_mean() + line.slope() * (place(at) - line.x_mean());
  return std::max(median(beside) / std::numbers::ln2, std::exp(log + std::numbers::egamma)) / 2;
}

}  // namespace

std::optional<Hum> find_hum(const RunView& view, const Rests& rests,
                            const MeasuredLevels& measured) {
  const HumSearch coarse(view, rests, measured, kHumBlock_s);
  if (coarse.blocks() < 2 || !(coarse.length_s() > 0)) return std::nullopt;
  const double highest_Hz = std::min(kHighest_Hz, 1 / (kReadingsAPeriod * coarse.block_s()));
  double step_Hz = 1 / (kOversampling * coarse.length_s());
  const double steps = (highest_Hz - kLowest_Hz) / step_Hz;
  if (steps < kLeastFrequencies || steps * static_cast<double>(coarse.blocks()) > kMostWork) {
    return std::nullopt;
  }
  const auto count = static_cast<std::size_t>(steps);
  const auto fits = coarse.fit_all(kLowest_Hz, step_Hz, count);
  const auto best = std::ranges::max_element(fits, {}, &SineFit::explained);
  const auto at = static_cast<std::size_t>(best - fits.begin());
  const double noise = noise_at(fits, at, kLowest_Hz / step_Hz);
  const double least = 2 * std::log(static_cast<double>(count) / kFalseHum);
  if (!(noise > 0) || best->explained <= least * noise) return std::nullopt;

  const HumSearch fine(view, rests, measured, 0);
  double frequency_Hz = kLowest_Hz + step_Hz * static_cast<double>(at);
  SineFit sine = fine.fit(frequency_Hz);
  for (int i = 0; i < kRefinements; ++i) {
    step_Hz /= kHalf;
    const double middle_Hz = frequency_Hz;
    for (int k = -kHalf; k <= kHalf; ++k) {
      const SineFit other = fine.fit(middle_Hz + k * step_Hz);
      if (other.explained <= sine.explained) continue;
      sine = other;
      frequency_Hz = middle_Hz + k * step_Hz;
    }
  }
  return Hum{frequency_Hz, sine.cosine_fF, sine.sine_fF};
}

RunData without(const Hum& hum, const RunData& data) {
  RunData out = data;
  for (RunReading& r : out.readings) r.capacitance_F -= hum.at(r.t_s) * 1e-15;
  return out;
}

std::string note_on(const Hum& hum) {
  return fmt::format(
      "a beat of {:.3g} s, {:.2g} fF was subtracted from all readings: it goes on through loads "
      "and rests alike, which no specimen does; look for the mains, or for what else turns at that "
      "rate",
      hum.period_s(), hum.amplitude_fF());
}

}  // namespace lcrig
