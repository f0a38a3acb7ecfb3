// SPDX-License-Identifier: Apache-2.0
#include "tests/property/lie_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

namespace lcrig::property {

namespace {

double quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  std::ranges::sort(v);
  return v[static_cast<std::size_t>(q * static_cast<double>(v.size() - 1))];
}

}  // namespace

void LieTable::add(const LieTable& more) {
  for (const auto& [lie, f] : more.rows_) {
    LieFigures& all = rows_[lie];
    all.told += f.told;
    all.contradicted += f.contradicted;
    all.noticed += f.noticed;
    all.to_stop_s.insert(all.to_stop_s.end(), f.to_stop_s.begin(), f.to_stop_s.end());
    all.worst_of_bound = std::max(all.worst_of_bound, f.worst_of_bound);
    if (f.worst_of_limit <= all.worst_of_limit) continue;
    all.worst_of_limit = f.worst_of_limit;
    all.worst_seed = f.worst_seed;
  }
}

void LieTable::write(const std::string& name) const {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  for (const auto& [lie, f] : rows_) {
    const double p50 = quantile(f.to_stop_s, 0.5), most = quantile(f.to_stop_s, 1);
    out[std::string(to_string(lie))] = {{"told", f.told},
                                        {"contradicted", f.contradicted},
                                        {"noticed", f.noticed},
                                        {"to_stop_s", {{"p50", p50}, {"max", most}}},
                                        {"worst_true_force_of_limit", f.worst_of_limit},
                                        {"worst_true_force_of_bound", f.worst_of_bound},
                                        {"seed", f.worst_seed}};
    if (std::getenv("LCRIG_VERBOSE") == nullptr) continue;
    fmt::print(stderr, "| {} | {} | {} | {} | {:.3g} s | {:.3g} s | {:.2f} | {:.2f} |\n",
               to_string(lie), f.told, f.contradicted, f.noticed, p50, most, f.worst_of_limit,
               f.worst_of_bound);
  }
  const char* folder = std::getenv("LCRIG_SWEEP");
  if (folder != nullptr) std::ofstream(std::string(folder) + "/" + name + ".json") << out.dump(1);
}

}  // namespace lcrig::property
