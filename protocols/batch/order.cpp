// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <random>
#include <tuple>

#include "protocols/batch/batch.hpp"

namespace lcrig {

namespace {

// Shuffles by hand, because std::shuffle and the distributions differ between libraries. The engine
// does not.
void shuffle_turns(std::span<BatchTurn> turns, std::mt19937_64& random) {
  for (std::size_t left = turns.size(); left > 1; --left) {
    const std::uint64_t most = random.max() - random.max() % left;
    std::uint64_t drawn = random();
    while (drawn >= most) drawn = random();  // otherwise the first places would be drawn more often
    std::swap(turns[left - 1], turns[drawn % left]);
  }
}

// For each entry the number of its specimen, in the order of the table.
std::vector<std::size_t> blocks_of(std::span<const BatchEntry> entries) {
  std::map<std::string_view, std::size_t> known;
  std::vector<std::size_t> out;
  out.reserve(entries.size());
  for (const BatchEntry& entry : entries) {
    out.push_back(known.emplace(entry.specimen_name, known.size()).first->second);
  }
  return out;
}

}  // namespace

std::vector<BatchTurn> order_batch(std::span<const BatchEntry> entries, BatchOrder order,
                                   std::uint64_t seed) {
  std::vector<BatchTurn> turns;
  for (std::size_t row = 0; row < entries.size(); ++row) {
    for (std::int64_t repeat = 1; repeat <= entries[row].repeats; ++repeat) {
      turns.push_back({row, repeat});
    }
  }
  std::mt19937_64 random(seed);
  if (order == BatchOrder::random) shuffle_turns(turns, random);
  if (order != BatchOrder::blocks) return turns;
  const auto block = blocks_of(entries);
  const auto block_of = [&block](const BatchTurn& turn) { return block[turn.row]; };
  std::ranges::sort(turns, {}, [&block_of](const BatchTurn& turn) {
    return std::tuple(block_of(turn), turn.row, turn.repeat);
  });
  for (auto begin = turns.begin(); begin != turns.end();) {
    const auto end = std::find_if(begin, turns.end(), [&](const BatchTurn& turn) {
      return block_of(turn) != block_of(*begin);
    });
    shuffle_turns(std::span(begin, end), random);
    begin = end;
  }
  return turns;
}

}  // namespace lcrig
