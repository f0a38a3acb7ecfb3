// SPDX-License-Identifier: Apache-2.0
// Sum of 1/t over {sum t = total, t >= least} is convex, so its maximum is a vertex: all layers but
// one at the least thickness. With free faces it does not matter which. With a bonded base layers
// near the base hardly strain, so the position decides; every vertex is computed from one field.
#include "model/design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/curve.hpp"
#include "model/fem_levels.hpp"

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
  for (const double t : thickness_m) {
    s.capacitors.push_back({{{0, t}}});
  }
  return s;
}

std::string placement_name(int position, int count) {
  if (position == 0) {
    return "thin layers at the top, the thick one at the base";
  }
  if (position == count - 1) {
    return "thin layers at the base, the thick one on top";
  }
  return fmt::format("the thick layer is number {} from the base", position + 1);
}

Result<DesignOption> rate(const DesignRequest& r, const Evaluate& evaluate, std::string placement,
                          Partition partition) {
  DesignOption option;
  option.placement = std::move(placement);
  option.c0_F = block_of(r, partition).c0_F();
  const Pressure tiny = r.max_pressure * 1e-7;
  const auto start = evaluate(partition, tiny);
  if (!start) {
    return fail(start.error());
  }
  option.initial_F_Pa = start->delta_capacitance_F / tiny.si();
  std::vector<ModelPoint> points;
  for (int i = 0; i <= 10; ++i) {
    const Pressure p = r.max_pressure * (i / 10.0);
    const auto state = evaluate(partition, p);
    if (!state) {
      break;
    }
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

// A level for each partition anew where layers do not share one field, else one factorization.
Result<Evaluate> make_evaluate(const DesignRequest& r, std::string& method) {
  if (r.faces == Faces::bonded_base) {
    auto field = FemLinear::make(block_of(r, {r.total.si()}), LevelSettings{});
    if (!field) {
      return fail(field.error());
    }
    method =
        "linear finite elements, one factorization for all partitions: the bonded base strains "
        "little, so the place of the thin layers matters";
    return Evaluate(
        [shared = std::shared_ptr<FemLinear>(std::move(*field))](
            const Partition& partition, Pressure p) { return shared->at_pressure(p, partition); });
  }
  LevelSettings settings;
  settings.level = r.faces == Faces::free ? Level::linear : Level::bonded;
  settings.nonlinear = false;
  method = r.faces == Faces::free
               ? "closed form: sensitivity goes with the sum of 1/t, the order does not matter"
               : "bonded layers: thinner layers are also stiffer, each by its own shape factor";
  return Evaluate([r, settings](const Partition& partition, Pressure p) -> Result<StackState> {
    auto model = make_level_model(block_of(r, partition), settings);
    if (!model) {
      return fail(model.error());
    }
    return (*model)->at_pressure(p);
  });
}

}  // namespace

Result<Design> design_partition(const DesignRequest& r) {
  if (auto ok = check(r); !ok) {
    return fail(ok.error());
  }
  Design design;
  auto evaluate = make_evaluate(r, design.method);
  if (!evaluate) {
    return fail(evaluate.error());
  }
  const auto n = static_cast<std::size_t>(r.capacitors);
  const double rest = r.total.si() - r.least_layer.si() * (r.capacitors - 1);
  std::vector<std::pair<std::string, Partition>> partitions{
      {"equal layers", Partition(n, r.total.si() / r.capacitors)}};
  const int positions = r.faces == Faces::bonded_base ? r.capacitors : std::min(r.capacitors, 1);
  for (int i = 0; i < positions && n > 1; ++i) {
    Partition p(n, r.least_layer.si());
    p[static_cast<std::size_t>(i)] = rest;
    partitions.emplace_back(placement_name(i, r.capacitors), p);
  }
  for (auto& [name, partition] : partitions) {
    auto option = rate(r, *evaluate, name, partition);
    if (!option) {
      return fail(option.error());
    }
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
    for (const double t : o.thickness_m) {
      layers.push_back(t * 1e6);
    }
    nlohmann::json row{{"placement", o.placement},
                       {"thickness_um", layers},
                       {"C0_pF", o.c0_F * 1e12},
                       {"sensitivity_fF_per_kPa", o.initial_F_Pa * 1e18},
                       {"gain_percent", o.gain * 100}};
    row["fitted_sensitivity_fF_per_kPa"] =
        o.fitted_F_Pa > 0 ? nlohmann::json(o.fitted_F_Pa * 1e18) : nlohmann::json(nullptr);
    options.push_back(std::move(row));
  }
  return {{"method", design.method}, {"options", options}};
}

}  // namespace lcrig
