// SPDX-License-Identifier: Apache-2.0
#include "model/partition_search.hpp"

#include <cstddef>

namespace lcrig {
namespace {

constexpr std::size_t kGrid = 120;  // steps into which the spare thickness is divided
constexpr int kHalvings = 12;  // of the grid step, when leaving the grid
constexpr int kMostSweeps = 100;

// The best sensitivity of the lowest layers for a share of the spare thickness, and the part of
// this share that the uppermost of them gets.
struct Best {
  double value = 0;
  std::size_t last = 0;
};

class Search {
 public:
  Search(const PartitionRequest& request, const LayerSensitivity& sensitivity)
      : layers_(static_cast<std::size_t>(request.layers)),
        request_(request),
        sensitivity_(sensitivity),
        step_m_((request.total_m - request.layers * request.least_m) / kGrid) {}

  double step_m() const { return step_m_; }
  // Heights of the boundaries, base to top, on the grid.

  std::vector<double> on_grid() const {
    std::vector<std::vector<Best>> best(layers_ + 1, std::vector<Best>(kGrid + 1));
    for (std::size_t n = 1; n <= layers_; ++n) {
      for (std::size_t spare = 0; spare <= kGrid; ++spare) {
        Best& here = best[n][spare];
        for (std::size_t last = n == 1 ? spare : 0; last <= spare; ++last) {
          const double value = best[n - 1][spare - last].value +
                               sensitivity_(height_m(n - 1, spare - last), height_m(n, spare));
          if (last == (n == 1 ? spare : 0) || value > here.value) here = {value, last};
        }
      }
    }
    std::vector<double> z(layers_ + 1);
    std::size_t spare = kGrid;
    for (std::size_t n = layers_; n > 0; --n) {
      z[n] = height_m(n, spare);
      spare -= best[n][spare].last;
    }
    return z;
  }

  void refine(std::vector<double>& z) const {
    double step = step_m_;
    for (int halving = 0; halving < kHalvings; ++halving) {
      step /= 2;
      bool moved = true;
      for (int sweep = 0; sweep < kMostSweeps && moved; ++sweep) {
        moved = false;
        for (std::size_t b = 1; b < layers_; ++b) {
          moved = move(z, b, step) || move(z, b, -step) || moved;
        }
      }
    }
  }

  double total(const std::vector<double>& z) const {
    double sum = 0;
    for (std::size_t n = 1; n <= layers_; ++n) sum += sensitivity_(z[n - 1], z[n]);
    return sum;
  }

 private:
  double height_m(std::size_t layers, std::size_t spare) const {
    const bool all = layers == layers_ && spare == kGrid;
    return all ? request_.total_m
               : static_cast<double>(layers) * request_.least_m +
                     static_cast<double>(spare) * step_m_;
  }

  // Moves one boundary if that improves the two layers next to it. True if it did.
  bool move(std::vector<double>& z, std::size_t boundary, double by_m) const {
    const double below = z[boundary - 1], at = z[boundary], above = z[boundary + 1];
    const double least = request_.least_m * (1 - 1e-12);
    const double to = at + by_m;
    if (to - below < least || above - to < least) return false;
    const double before = sensitivity_(below, at) + sensitivity_(at, above);
    const double after = sensitivity_(below, to) + sensitivity_(to, above);
    if (after <= before * (1 + 1e-12)) return false;
    z[boundary] = to;
    return true;
  }

  std::size_t layers_;
  const PartitionRequest& request_;
  const LayerSensitivity& sensitivity_;
  double step_m_;
};

}  // namespace

FoundPartition best_partition(const PartitionRequest& request,
                              const LayerSensitivity& sensitivity) {
  const Search search(request, sensitivity);
  std::vector<double> z = search.on_grid();
  search.refine(z);
  FoundPartition found;
  for (std::size_t n = 1; n < z.size(); ++n) found.thickness_m.push_back(z[n] - z[n - 1]);
  found.sensitivity_F_Pa = search.total(z);
  found.grid_m = search.step_m();
  return found;
}

}  // namespace lcrig
