// SPDX-License-Identifier: Apache-2.0
#include "analysis/quiet_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

constexpr double kBlocks = 40;  // approximate number of blocks in all
constexpr std::size_t kMostStretches = 32;  // with more rests than this, several form one block

class Blocks {
 public:
  Blocks(const Scene& scene, QuietBlocks& out) : scene_(scene), out_(out) {}

  // Cuts the readings of nodes [first, last) into `count` blocks.
  void cut(std::size_t first, std::size_t last, std::size_t count) {
    std::vector<const RunReading*> readings;
    std::vector<std::size_t> node;
    const auto& nodes = scene_.drift.nodes();
    for (std::size_t k = first; k < last; ++k) {
      for (std::size_t i = nodes[k].first; i < nodes[k].last; ++i) {
        const RunReading& r = scene_.data.readings[i];
        if (scene_.uses(r)) readings.push_back(&r), node.push_back(k);
      }
    }
    count = std::clamp<std::size_t>(count, 1, readings.size());
    for (std::size_t b = 0; b < count; ++b) {
      add(readings, node, b * readings.size() / count, (b + 1) * readings.size() / count);
    }
  }

 private:
  void add(const std::vector<const RunReading*>& readings, const std::vector<std::size_t>& node,
           std::size_t from, std::size_t to) {
    const auto n = static_cast<double>(to - from);
    std::vector<double> fF;
    double time = 0;
    out_.of_node.emplace_back();
    for (std::size_t i = from; i < to; ++i) {
      fF.push_back(readings[i]->capacitance_F * 1e15);
      time += readings[i]->t_s / n;
      auto& nodes = out_.of_node.back();
      if (nodes.empty() || nodes.back().node != node[i]) nodes.push_back({node[i], 0});
      nodes.back().readings += 1;
    }
    QuietBlock b;
    b.t_s = time;
    const double span = readings[to - 1]->t_s - readings[from]->t_s;
    b.length_s = n > 1 ? span * n / (n - 1) : 0;
    b.fF = huber_location(fF);
    b.share = scene_.rest_correlation.of_mean(n);
    b.loaded_before = node[from] > 0;
    out_.blocks.push_back(b);
  }

  const Scene& scene_;
  QuietBlocks& out_;
};

}  // namespace

QuietBlocks cut_quiet_blocks(const Scene& scene) {
  QuietBlocks out;
  const auto& nodes = scene.drift.nodes();
  if (nodes.empty()) return out;
  double total = 0;
  for (const RestNode& n : nodes) total += n.readings;
  const double each = std::ceil(total / kBlocks);
  const std::size_t together = (nodes.size() + kMostStretches - 1) / kMostStretches;
  Blocks blocks(scene, out);
  blocks.cut(0, 1, static_cast<std::size_t>(std::lround(nodes[0].readings / each)));
  for (std::size_t k = 1; k < nodes.size(); k += together) {
    const std::size_t end = std::min(nodes.size(), k + together);
    const double wanted = together > 1 ? 1 : nodes[k].readings / each;
    blocks.cut(k, end, static_cast<std::size_t>(std::lround(wanted)));
  }
  return out;
}

}  // namespace lcrig
