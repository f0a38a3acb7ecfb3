// SPDX-License-Identifier: Apache-2.0
#include "tests/property/sweep.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/property/recipe.hpp"

namespace lcrig::property {

namespace {

constexpr std::int64_t kDefaultPairs = 60;
constexpr std::uint64_t kDefaultSeed = 20260101;
constexpr int kShrinkTrials = 80;
// this many are shrunk and reported, the others only counted
constexpr std::size_t kMostFailures = 5;

std::uint64_t number_of(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

// splitmix64, so that neighbouring numbers give unrelated seeds.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

rc::Gen<Choice> choices() {
  return rc::gen::map(
      rc::gen::pair(rc::gen::inRange(0, kKindsOfSteps),
                    rc::gen::container<std::array<int, 4>>(rc::gen::inRange(0, 1001))),
      [](const std::pair<int, std::array<int, 4>>& p) {
        Choice c;
        c.kind = p.first;
        c.at = p.second;
        return c;
      });
}

rc::Gen<Recipe> recipes(int beyond) {
  // Short protocols, because long ones find nothing that many short ones do not.
  auto steps = rc::gen::scale(
      0.07, rc::gen::container<std::vector<Choice>>(rc::gen::resize(rc::kNominalSize, choices())));
  return rc::gen::map(
      rc::gen::tuple(rc::gen::inRange(0, 1000), rc::gen::inRange(200, 700),
                     rc::gen::container<std::array<int, 10>>(rc::gen::inRange(0, 1001)), steps),
      [beyond](const std::tuple<int, int, std::array<int, 10>, std::vector<Choice>>& t) {
        Recipe r;
        r.beyond = std::get<0>(t) < beyond ? std::get<1>(t) : 0;
        r.base = std::get<2>(t);
        r.steps = std::get<3>(t);
        return r;
      });
}

Case make_case(const Kind& kind, std::uint64_t seed, std::uint32_t without, const Recipe& recipe) {
  Case c;
  c.property = kind.name;
  c.rig = seed;
  c.without = without;
  if (kind.lies) c.lie = sim::random_lie(seed);
  const Written written = write_protocol(recipe, sim::random_rig(seed, [&] {
                                           sim::RigOptions o;
                                           o.without = without;
                                           return o;
                                         }()));
  c.gap_m = written.gap_m;
  c.is_within = recipe.beyond == 0;
  c.protocol = written.text;
  if (kind.disturb) kind.disturb(mix(seed), c);
  return c;
}

std::string kind_of(const std::string& broken) {
  return broken.substr(0, broken.find(':'));
}

struct Failure {
  Case plainest;
  std::string words;
};

class Sweep {
 public:
  Sweep(const Kind& kind, const Judge& judge) : kind_(kind), judge_(judge) {
    const char* folder = std::getenv("LCRIG_SWEEP");
    if (folder == nullptr) return;
    folder_ = folder;
    std::filesystem::create_directories(folder_);
    csv_.open(folder_ + "/overshoot-" + kind.name + ".csv");
    csv_ << "seed,threshold_N,predicted_N,observed_N,noise_N\n";
  }

  void pair(std::uint64_t seed) {
    const auto drawn = recipes(kind_.beyond)(rc::Random(seed), rc::kNominalSize);
    const Case c = make_case(kind_, seed, 0, drawn.value());
    Trial t(c);
    const Broken broken = carry_out(t, summary_.counters);
    if (kind_.note) kind_.note(t);
    ++summary_.pairs;
    note_worst(t);
    tell(t);
    if (broken.empty()) {
      ++summary_.held;
      return;
    }
    if (summary_.failures.size() >= kMostFailures && folder_.empty()) return;
    Failure f{c, broken.front()};
    if (summary_.failures.size() < kMostFailures) f = shrink(drawn, seed, std::move(f));
    summary_.failures.push_back(f.words + "\n" + to_json_text(f.plainest));
  }

  Summary take() {
    if (!folder_.empty()) write_json();
    return std::move(summary_);
  }

 private:
  Broken carry_out(Trial& t, Counters& counters) const {
    try {
      t.run();
      t.count(counters);
      return judge_(t, counters);
    } catch (const std::exception& e) {
      return {fmt::format("exception: {}", e.what())};
    }
  }

  std::string fails_alike(const Case& c, const std::string& words) {
    Counters nowhere;
    Trial t(c);
    for (const std::string& b : carry_out(t, nowhere)) {
      if (kind_of(b) == kind_of(words)) return b;
    }
    return "";
  }

  // First simplifies the protocol, then the rig.
  Failure shrink(rc::Shrinkable<Recipe> at, std::uint64_t seed, Failure f) {
    int left = kShrinkTrials;
    for (bool found = true; found && left > 0;) {
      found = false;
      auto children = at.shrinks();
      for (auto child = children.next(); child && left > 0 && !found; --left) {
        const Case c = make_case(kind_, seed, 0, child->value());
        if (const std::string words = fails_alike(c, f.words); !words.empty()) {
          f = Failure{c, words};
          at = *child;
          found = true;
        } else {
          child = children.next();
        }
      }
    }
    for (std::uint32_t bit = 1; bit < sim::kAllQuirks; bit <<= 1U) {
      const std::uint32_t without = f.plainest.without | bit;
      const Case c = make_case(kind_, seed, without, at.value());
      const std::string words = fails_alike(c, f.words);
      if (!words.empty()) f = Failure{c, words};
    }
    return f;
  }

  void tell(Trial& t) const {
    if (!verbose_) return;
    const RigWorld& w = t.world();
    std::string what = w.refused ? "refused " + w.refused->what : "accepted";
    if (w.result) {
      what += fmt::format(", ended {} {}", to_string(w.result->exit_status), w.result->reason);
    }
    fmt::print(stderr, "random:{} {}\n", t.what().rig, what);
    if (std::getenv("LCRIG_ONLY") != nullptr) fmt::print(stderr, "{}\n", to_json_text(t.what()));
    for (const Overshoot& o : w.overshoots) {
      if (o.exceeded) {
        fmt::print(stderr, "  broken: threshold {:.6g} N predicted {:.6g} N observed {:.6g} N\n",
                   o.threshold_N, o.predicted_N, o.observed_N);
      }
    }
  }

  void note_worst(Trial& t) {
    const RigWorld& w = t.world();
    if (!w.plan) return;
    Worst& worst = summary_.worst;
    const double over = w.all.peak_N - t.limit_N();
    const double part = over / t.uncertainty_N();
    if (part > worst.over_limit_of_uncertainty) {
      worst.over_limit_N = over;
      worst.over_limit_of_uncertainty = part;
      worst.over_limit_seed = t.what().rig;
    }
    for (const Overshoot& o : w.overshoots) {
      const double ratio = o.observed_N / o.predicted_N;
      if (ratio > worst.overshoot_ratio) {
        worst.overshoot_ratio = ratio;
        worst.overshoot_seed = t.what().rig;
      }
      if (csv_.is_open()) {
        csv_ << fmt::format("{},{:.9g},{:.9g},{:.9g},{:.3g}\n", t.what().rig, o.threshold_N,
                            o.predicted_N, o.observed_N, t.rig().plant.force_noise_N);
      }
    }
  }

  void write_json() const {
    const Worst& w = summary_.worst;
    nlohmann::ordered_json out{{"property", kind_.name},
                               {"pairs", summary_.pairs},
                               {"held", summary_.held},
                               {"counters", summary_.counters},
                               {"largest_true_force",
                                {{"over_limit_N", w.over_limit_N},
                                 {"of_printed_uncertainty", w.over_limit_of_uncertainty},
                                 {"seed", w.over_limit_seed}}},
                               {"largest_observed_of_predicted",
                                {{"ratio", w.overshoot_ratio}, {"seed", w.overshoot_seed}}},
                               {"failures", summary_.failures}};
    std::ofstream(folder_ + "/" + kind_.name + ".json") << out.dump(1) << "\n";
  }

  const Kind& kind_;
  const Judge& judge_;
  Summary summary_;
  const bool verbose_ = std::getenv("LCRIG_VERBOSE") != nullptr;
  std::string folder_;
  std::ofstream csv_;
};

}  // namespace

Summary sweep(const Kind& kind, const Judge& judge, const std::vector<std::string>& sometimes) {
  const std::uint64_t base = number_of("LCRIG_SEED", kDefaultSeed);
  const auto all = static_cast<double>(number_of("LCRIG_PAIRS", kDefaultPairs));
  const auto first = static_cast<std::int64_t>(number_of("LCRIG_FIRST", 0));
  const auto pairs = std::max<std::int64_t>(1, std::llround(all * kind.share));
  const bool verbose = std::getenv("LCRIG_VERBOSE") != nullptr;
  Sweep s(kind, judge);
  if (const std::uint64_t only = number_of("LCRIG_ONLY", 0); only != 0) {
    s.pair(only);
    for (const std::string& f : s.take().failures) ADD_FAILURE() << f;
    return {};
  }
  for (std::int64_t i = first; i < first + pairs; ++i) {
    const std::uint64_t seed = mix(base + static_cast<std::uint64_t>(i)) >> 11U;
    s.pair(seed);
  }
  Summary out = s.take();
  for (std::size_t i = 0; i < std::min(out.failures.size(), kMostFailures); ++i) {
    ADD_FAILURE() << kind.name << ": " << out.failures[i]
                  << "\nagain: put this line into a file and run LCRIG_CASE=FILE "
                     "tests/property_tests --gtest_filter='*OneCase'";
  }
  EXPECT_EQ(out.held, out.pairs) << kind.name;
  for (const std::string& name : sometimes) {
    EXPECT_GT(out.counters[name], 0) << kind.name << " never met: " << name;
  }
  for (const auto& [name, n] : out.counters) {
    testing::Test::RecordProperty(std::regex_replace(name, std::regex("[^a-z0-9]+"), "_"),
                                  std::to_string(n));
    if (verbose) fmt::print(stderr, "{:8} {}\n", n, name);
  }
  return out;
}

}  // namespace lcrig::property
