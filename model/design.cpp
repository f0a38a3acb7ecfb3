// SPDX-License-Identifier: Apache-2.0
// The sum of 1/t over {sum t = total, t >= least} is convex, so its maximum is a vertex: all layers
// but one have the least thickness. With free faces it does not matter which one is thick. With a
// bonded base the position matters, because layers near the base hardly strain. Between films, thin
// layers are stiffer. In these two cases a vertex need not be the best, so every partition on a
// grid is tried.
#include "model/design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/bonded.hpp"
#include "model/curve.hpp"
#include "model/fem_levels.hpp"
#include "model/partition_search.hpp"

namespace lcrig {
namespace {

using Partition = std::vector<double>;
using Evaluate = std::function<Result<StackState>(const Partition&, Pressure)>;

Specimen block_of(const DesignRequest& r, const Partition& thickness_m) {
  Specimen s;
  s.name = "design";
  s.disc_diameter_m = r.disc_diameter.si();
  s.faces = r.faces;
  s.top = r.top;
  s.materials = {r.material};
  for (const double t : thickness_m) s.capacitors.push_back({{{0, t}}});
  return s;
}

std::string placement_name(int position, int count) {
  if (position == 0) return "thin layers at the top, the thick one at the base";
  if (position == count - 1) return "thin layers at the base, the thick one on top";
  return fmt::format("the thick layer is number {} from the base", position + 1);
}

Result<DesignOption> rate(const DesignRequest& r, const Evaluate& evaluate, std::string placement,
                          Partition partition) {
  DesignOption option;
  option.placement = std::move(placement);
  option.c0_F = block_of(r, partition).c0_F();
  const Pressure tiny = r.max_pressure * 1e-7;
  const auto start = evaluate(partition, tiny);
  if (!start) return fail(start.error());
  option.initial_F_Pa = start->delta_capacitance_F / tiny.si();
  std::vector<ModelPoint> points;
  for (int i = 0; i <= 10; ++i) {
    const Pressure p = r.max_pressure * (i / 10.0);
    const auto state = evaluate(partition, p);
    if (!state) break;
    points.push_back({p.si(), 0, state->delta_capacitance_F, state->shortening_m});
  }
  option.fitted_F_Pa = points.size() == 11 ? fit_slope(points) : 0;
  option.thickness_m = std::move(partition);
  return option;
}

Result<> check(const DesignRequest& r) {
  const double total = r.total.si(), least = r.least_layer.si();
  if (r.capacitors < 1 || r.capacitors > 100) {
    return fail(Errc::invalid_request, "design: {} capacitors, expected 1 to 100", r.capacitors);
  }
  if (!std::isfinite(total) || !(total > 0) || !(least > 0) || !(r.max_pressure.si() > 0)) {
    return fail(Errc::invalid_request,
                "design: total thickness, least layer and largest pressure must be positive");
  }
  if (r.capacitors * least > total * (1 + 1e-12)) {
    return fail(Errc::invalid_request, "design: {} layers of at least {} mm do not fit into {} mm",
                r.capacitors, least * 1e3, total * 1e3);
  }
  return check_specimen(block_of(r, {total}));
}

// How partitions are rated at a pressure, and what a single layer contributes at zero pressure.
struct Rating {
  std::string method;
  Evaluate evaluate;
  LayerSensitivity sensitivity;  // empty: the closed form needs no search
};

Evaluate closed_form(const DesignRequest& r, Level level) {
  LevelSettings settings;
  settings.level = level;
  settings.nonlinear = false;
  return [r, settings](const Partition& partition, Pressure p) -> Result<StackState> {
    auto model = make_level_model(block_of(r, partition), settings);
    if (!model) return fail(model.error());
    return (*model)->at_pressure(p);
  };
}

// One factorization serves every partition, because the field does not depend on the cuts.
Result<Rating> rate_bonded_base(const DesignRequest& r) {
  auto field = FemLinear::make(block_of(r, {r.total.si()}), LevelSettings{});
  if (!field) return fail(field.error());
  Rating rating;
  rating.method =
      "linear finite elements, one factorization for all partitions: the bonded base strains "
      "little, so the place of the thin layers matters";
  const std::shared_ptr<FemLinear> shared(std::move(*field));
  rating.evaluate = [shared](const Partition& partition, Pressure p) {
    return shared->at_pressure(p, partition);
  };
  const double eps = kVacuumPermittivity_F_m * r.material.relative_permittivity;
  rating.sensitivity = [shared, eps](double from, double to) {
    const double t = to - from;
    return eps * (shared->swept_volume_m3_Pa(to) - shared->swept_volume_m3_Pa(from)) / (t * t);
  };
  return rating;
}

Rating rate_laminate(const DesignRequest& r) {
  Rating rating;
  rating.method = "bonded layers: thinner layers are also stiffer, each by its own shape factor";
  rating.evaluate = closed_form(r, Level::bonded);
  const Specimen block = block_of(r, {r.total.si()});
  const double eps_area =
      kVacuumPermittivity_F_m * r.material.relative_permittivity * block.area_m2();
  const double radius = r.disc_diameter.si() / 2;
  const double nu = r.material.poisson_ratio;
  const double mu = r.material.youngs_modulus_Pa / (2 * (1 + nu));
  rating.sensitivity = [=](double from, double to) {
    const double t = to - from;
    return eps_area / (t * bonded_modulus_Pa(mu, nu, radius / (2 * t)));
  };
  return rating;
}

Result<Rating> make_rating(const DesignRequest& r) {
  if (r.faces == Faces::bonded_base) return rate_bonded_base(r);
  if (r.faces == Faces::bonded_laminate) return rate_laminate(r);
  return Rating{"closed form: sensitivity goes with the sum of 1/t, the order does not matter",
                closed_form(r, Level::linear), nullptr};
}

// Equal layers, then every vertex that gives a different result.
std::vector<std::pair<std::string, Partition>> named_partitions(const DesignRequest& r) {
  const auto n = static_cast<std::size_t>(r.capacitors);
  const double rest = r.total.si() - r.least_layer.si() * (r.capacitors - 1);
  std::vector<std::pair<std::string, Partition>> partitions{
      {"equal layers", Partition(n, r.total.si() / r.capacitors)}};
  const std::size_t positions = n == 1 ? 0 : r.faces == Faces::bonded_base ? n : 1;
  for (std::size_t i = 0; i < positions; ++i) {
    Partition p(n, r.least_layer.si());
    p[i] = rest;
    const std::string name = r.faces == Faces::bonded_base
                                 ? placement_name(static_cast<int>(i), r.capacitors)
                                 : "one thick layer, anywhere";
    partitions.emplace_back(name, std::move(p));
  }
  return partitions;
}

bool same(const Partition& a, const Partition& b, double total_m) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst < 1e-6 * total_m;
}

// Searches all partitions. The best one joins the list unless it is already there.
void search(const DesignRequest& r, const Rating& rating, Design& design,
            std::vector<std::pair<std::string, Partition>>& partitions) {
  const auto found =
      best_partition({r.capacitors, r.total.si(), r.least_layer.si()}, rating.sensitivity);
  design.search_grid_m = found.grid_m;
  const auto listed = std::find_if(partitions.begin(), partitions.end(), [&](const auto& p) {
    Partition sorted = p.second, best = found.thickness_m;
    if (r.faces == Faces::bonded_laminate) {  // the order does not matter
      std::sort(sorted.begin(), sorted.end());
      std::sort(best.begin(), best.end());
    }
    return same(sorted, best, r.total.si());
  });
  if (listed == partitions.end()) partitions.emplace_back("found by search", found.thickness_m);
}

}  // namespace

Result<Design> design_partition(const DesignRequest& r) {
  if (auto ok = check(r); !ok) return fail(ok.error());
  Design design;
  const auto rating = make_rating(r);
  if (!rating) return fail(rating.error());
  design.method = rating->method;
  auto partitions = named_partitions(r);
  if (rating->sensitivity && r.capacitors > 1) search(r, *rating, design, partitions);
  for (auto& [name, partition] : partitions) {
    auto option = rate(r, rating->evaluate, name, partition);
    if (!option) return fail(option.error());
    option->gain =
        design.options.empty() ? 0 : option->initial_F_Pa / design.options.front().initial_F_Pa - 1;
    design.options.push_back(std::move(*option));
  }
  std::sort(design.options.begin(), design.options.end(),
            [](const auto& a, const auto& b) { return a.initial_F_Pa > b.initial_F_Pa; });
  return design;
}

nlohmann::json to_json(const Design& design) {
  nlohmann::json options = nlohmann::json::array();
  for (const auto& o : design.options) {
    nlohmann::json layers = nlohmann::json::array();
    for (const double t : o.thickness_m) layers.push_back(t * 1e6);
    nlohmann::json row{{"placement", o.placement},
                       {"thickness_um", layers},
                       {"C0_pF", o.c0_F * 1e12},
                       {"sensitivity_fF_per_kPa", o.initial_F_Pa * 1e18},
                       {"gain_percent", o.gain * 100}};
    row["fitted_sensitivity_fF_per_kPa"] =
        o.fitted_F_Pa > 0 ? nlohmann::json(o.fitted_F_Pa * 1e18) : nlohmann::json(nullptr);
    options.push_back(std::move(row));
  }
  nlohmann::json json{{"method", design.method}, {"options", options}};
  json["search_grid_um"] = design.search_grid_m > 0 ? nlohmann::json(design.search_grid_m * 1e6)
                                                    : nlohmann::json(nullptr);
  return json;
}

}  // namespace lcrig
