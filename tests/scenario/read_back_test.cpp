// SPDX-License-Identifier: Apache-2.0
// A reading counts only between two equal read-backs of its settings (issue "Every word and every
// number true"). Restarts behind the port, hands at the panel and settings that take effect late,
// at random instants of random protocols. The truth of each reading is the record of the simulated
// meter; whether it counts follows from the stored rows alone, by a rule written here anew.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "drivers/faults/player.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "tests/support/loss_world.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {
namespace {

using lcr6100::SimSettings;
using nlohmann::json;

// A session whose meter keeps a record of the settings at which it measured.
class ProofWorld : public SessionWorld {
 public:
  ProofWorld(std::string protocol, std::string script, double late_s = 0)
      : SessionWorld(std::move(protocol)), script_(std::move(script)), late_s_(late_s) {
    in_memory = true;
  }
  ~ProofWorld() override { player_.reset(); }

  struct Told {
    std::optional<SimSettings> at;  // nullopt: they changed within the conversion
  };
  std::multimap<std::int64_t, Told> told;  // by the time of the answer, ns

 protected:
  void built() override {
    BenchDoor& door = *session->instruments().door();
    lcr6100::Lcr6100Sim& sim = door.meter_sim();
    sim.faults().late_settings_s = late_s_;
    sim.watch([this, &sim](MonoTime t, const std::string&) {
      told.emplace(t.time_since_epoch().count(), Told{sim.measured_at()});
    });
    auto script = parse_fault_script(
        R"({ "format": "faults/1", "faults": [)" +
            (script_.empty() ? R"({"fault":"stuck","on":"meter","at_s":1e6})" : script_) + "] }",
        "script");
    if (!script) throw std::runtime_error(script.error().what);
    player_ =
        std::make_unique<FaultPlayer>(io.get_executor(), clock, door, nullptr, std::move(*script),
                                      [](MonoTime, const std::string&) {});
  }
  void began() override { player_->begin(); }
  void ended() override { player_->stop(); }

 private:
  std::string script_;
  double late_s_;
  std::unique_ptr<FaultPlayer> player_;
};

struct Verdict {
  std::int64_t readings = 0, proven = 0, wrong = 0;  // wrong: measured at other settings
  std::int64_t wrong_and_proven = 0;
  std::string first;  // words about the first of these
};

// The bench had its corrections on before the run.
bool is_claimed(const SimSettings& at, const json& claim) {
  const auto near = [](double a, double b) { return std::abs(a - b) <= 2e-3 * std::abs(b); };
  static const std::map<std::string, std::size_t> kApertures{
      {"fast", 0}, {"medium", 1}, {"slow", 2}};
  const json& bias = claim.at("bias_V");
  return at.function == claim.at("function").get<std::string>() &&
         near(at.frequency_Hz, claim.at("frequency_Hz")) && near(at.level_V, claim.at("level_V")) &&
         at.aperture == kApertures.at(claim.at("aperture")) && at.average == claim.at("average") &&
         at.bias_V.has_value() == bias.is_number() && at.range == "AUTO" && at.open_correction &&
         at.short_correction;
}

struct Rows {
  std::map<std::int64_t, json> claims;  // settings of the run, by the time from which they hold
  std::vector<std::pair<std::int64_t, std::int64_t>> unproven;
  std::int64_t proven_before = -1;
  json plan;
};

Rows rows_of(const Database& db) {
  Rows out;
  auto run = db.prepare("SELECT lcr_settings_json FROM run").value();
  EXPECT_TRUE(run.step().value());
  out.claims[-1] = json::parse(run.text(0));
  auto row = db.prepare("SELECT at_mono_ns, kind, detail FROM event ORDER BY seq").value();
  while (row.step().value()) {
    const std::string kind(row.text(1));
    const json detail = json::parse(row.text(2), nullptr, false);
    if (kind == "plan") out.plan = detail;
    if (kind == "settings") out.claims[row.integer(0)] = detail;
    const bool equal = kind == "settings" || (kind == "read_back" && detail.at("equal") == true);
    if (equal) out.proven_before = row.integer(0);
    if (kind != "unproven") continue;
    out.unproven.emplace_back(detail.at("asked_from_mono_ns"), detail.at("asked_to_mono_ns"));
  }
  return out;
}

Verdict judge(const ProofWorld& world) {
  Verdict out;
  const Database db = world.open();
  const Rows rows = rows_of(db);
  auto row =
      db.prepare("SELECT asked_mono_ns, last_byte_mono_ns, seq FROM lcr_reading ORDER BY seq")
          .value();
  while (row.step().value()) {
    ++out.readings;
    const std::int64_t asked = row.integer(0), answered = row.integer(1);
    bool proven = asked < rows.proven_before;
    for (const auto& [from, to] : rows.unproven) proven = proven && (asked < from || asked > to);
    const json& claim = std::prev(rows.claims.upper_bound(asked))->second;
    auto truth = world.told.upper_bound(answered);
    if (truth == world.told.begin() || std::prev(truth)->first < asked) {
      ADD_FAILURE() << "the meter gave no reading number " << row.integer(2);
      continue;
    }
    const auto& at = std::prev(truth)->second.at;
    const bool right = at && is_claimed(*at, claim);
    out.proven += proven ? 1 : 0;
    out.wrong += right ? 0 : 1;
    if (right || !proven) continue;
    if (out.wrong_and_proven++ > 0) continue;
    out.first = fmt::format("asked at {:.3f} s, claimed {}, measured at {} {} Hz {} V",
                            static_cast<double>(asked) * 1e-9, claim.dump(),
                            at ? at->function : "mixed settings", at ? at->frequency_Hz : 0,
                            at ? at->level_V : 0);
  }
  return out;
}

constexpr const char* kStatic = R"(
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.4 }, "speed_mm_s": 0.02, "timeout_s": 60 },
    { "id": "level", "do": "measure", "count": 16, "within_s": 4 },
    { "id": "dense", "do": "measure", "count": 40, "within_s": 5 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.5 }, "speed_mm_s": 0.1, "timeout_s": 60 })";
constexpr const char* kDynamic = R"(
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "cycle", "do": "repeat", "count": 3, "steps": [
      { "id": "load", "do": "move_until", "until": { "force_N": 0.4 }, "speed_mm_s": 0.02, "timeout_s": 60 },
      { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.1 }, "speed_mm_s": 0.05, "timeout_s": 60 } ] })";
constexpr const char* kSweep = R"(
    { "id": "record", "do": "record", "for_s": 2 },
    { "id": "f", "do": "sweep", "name": "f_Hz", "values": [500, 10000, 100, 20000], "steps": [
      { "id": "set", "do": "set_lcr", "frequency_Hz": "$f_Hz" },
      { "id": "level", "do": "measure", "count": 12, "within_s": 2 },
      { "id": "more", "do": "record", "for_s": 2 } ] })";

std::string protocol_of(const char* steps, bool polled, const char* on_loss) {
  std::string text = loss_protocol(on_loss, steps);
  const std::string internal = R"("internal")";
  if (!polled) text.replace(text.find(internal), internal.size(), R"("bus")");
  return text;
}

// The longest time between two read-backs, as the plan prints it.
double printed_s(const std::string& protocol) {
  ProofWorld world(protocol, "");
  EXPECT_TRUE(world.run());
  const Rows rows = rows_of(world.open());
  const json& r = rows.plan.at("read_back");
  return std::max(r.at("recording_s").get<double>(),
                  r.at("level_s").is_number() ? r.at("level_s").get<double>() : 0.0);
}

struct Draw {
  std::string protocol, script;
  double late_s = 0;
};

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed) {}

  Draw next() {
    static constexpr std::array kSteps{kStatic, kDynamic, kSweep};
    static constexpr std::array kOnLoss{"wait", "repeat_step", "abort"};
    Draw out;
    const char* steps = kSteps.at(below(3));
    const bool polled = below(2) == 0;
    const char* on_loss = kOnLoss.at(below(3));
    out.protocol = protocol_of(steps, polled, on_loss);
    const double at_s = even(0, 30);
    switch (below(3)) {
      case 0:
        out.script =
            fmt::format(R"({{"fault":"restart_behind_port","on":"meter","at_s":{},"for_s":{}}})",
                        at_s, below(2) == 0 ? even(0.01, 0.2) : even(0.2, 9));
        break;
      case 1: out.script = panel(at_s, out.protocol); break;
      default: out.late_s = even(0, 1); break;
    }
    return out;
  }

 private:
  std::string panel(double at_s, const std::string& protocol) {
    static constexpr std::array<std::pair<const char*, const char*>, 10> kChanges{
        {{"function", "R-X"},
         {"function", "Cs-D"},
         {"frequency", "333"},
         {"level", "0.1"},
         {"aperture", "SLOW"},
         {"aperture", "MED"},
         {"average", "3"},
         {"range", "HOLD"},
         {"bias", "1.5"},
         {"correction", "OFF"}}};
    const auto [setting, to] = kChanges.at(below(kChanges.size()));
    auto known = printed_.find(protocol);
    if (known == printed_.end()) known = printed_.emplace(protocol, printed_s(protocol)).first;
    const double for_s = known->second * (1 + even(0, 2) * even(0, 2)) + 1e-3;
    return fmt::format(
        R"({{"fault":"panel_change","on":"meter","at_s":{},"for_s":{},"setting":"{}","to":"{}"}})",
        at_s, for_s, setting, to);
  }
  double even(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11U) * 0x1p-53);
  }
  std::size_t below(std::size_t n) {
    return std::min(n - 1, static_cast<std::size_t>(even(0, static_cast<double>(n))));
  }

  std::mt19937_64 random_;
  std::map<std::string, double> printed_;
};

// Readings of levels that count.
constexpr const char* kUnprovenInLevels =
    "SELECT COUNT(*) FROM event u JOIN lcr_reading r ON u.kind = 'unproven' AND r.asked_mono_ns "
    "BETWEEN u.detail ->> 'asked_from_mono_ns' AND u.detail ->> 'asked_to_mono_ns' "
    "WHERE r.level > 0 AND NOT EXISTS (SELECT 1 FROM event a WHERE a.kind = 'level_abandoned' AND "
    "a.detail ->> 'level' = r.level)";

// LCRIG_READ_BACKS=2000 draws as many.
TEST(ReadBack, NoReadingUnderOtherSettingsCountsAsProven) {
  const char* wanted = std::getenv("LCRIG_READ_BACKS");
  const int count = wanted != nullptr ? std::atoi(wanted) : 36;
  Draws draws(32);
  Verdict all;
  std::int64_t ended_well = 0;
  for (int i = 0; i < count; ++i) {
    const Draw draw = draws.next();
    ProofWorld world(draw.protocol, draw.script, draw.late_s);
    const auto result = world.run();
    ASSERT_TRUE(result) << result.error().what;
    const Verdict v = judge(world);
    EXPECT_EQ(v.wrong_and_proven, 0)
        << "draw " << i << ", late by " << draw.late_s << " s, " << draw.script << ": " << v.first;
    EXPECT_TRUE(result->exit_status == ExitStatus::success || !result->reason.empty());
    if (result->exit_status == ExitStatus::success) {
      EXPECT_EQ(world.count(kUnprovenInLevels), 0) << "draw " << i << ": " << draw.script;
    }
    all.readings += v.readings;
    all.proven += v.proven;
    all.wrong += v.wrong;
    all.wrong_and_proven += v.wrong_and_proven;
    ended_well += result->exit_status == ExitStatus::success ? 1 : 0;
  }
  EXPECT_GT(all.wrong, count / 4) << "the faults changed nothing";
  EXPECT_GT(ended_well, count / 3);
  fmt::print(
      stderr,
      "{} draws: {} readings, {} of them at other settings, {} proven, {} of these wrong; {} "
      "runs ended well\n",
      count, all.readings, all.wrong, all.proven, all.wrong_and_proven, ended_well);
}

// Each question takes 4 ms, as on the real line.
TEST(ReadBack, CostsAtMostTwoPercentOfTheReadingsAtFast) {
  for (const bool polled : {true, false}) {
    const auto readings = [&](const char* every_answer) {
      ProofWorld world(
          protocol_of(R"({ "id": "record", "do": "record", "for_s": 300 })", polled, "wait"),
          every_answer);
      EXPECT_TRUE(world.run());
      const std::int64_t n =
          world.count("SELECT COUNT(*) FROM lcr_reading WHERE step_id = 'record'");
      const std::int64_t backs = world.count("SELECT COUNT(*) FROM event WHERE kind = 'read_back'");
      const json printed = rows_of(world.open()).plan.at("read_back").at("cost_readings_per_s");
      return std::tuple(n, backs, 300 * printed.at("fast").get<double>());
    };
    const auto [with, backs, printed] =
        readings(R"({"fault":"reply_late","on":"meter","every":1,"delay_s":0.004})");
    EXPECT_GE(backs, 90);
    // A reading takes 65 ms; a poll finds it up to 4 ms later, a trigger adds question and answer.
    const double without = polled ? 300 / 0.065 : 300 / 0.069;
    fmt::print(stderr, "{}: {} readings in 300 s, {} read-backs, {:.2f} % fewer than {:.0f}\n",
               polled ? "polled" : "triggered", with, backs,
               100 * (1 - static_cast<double>(with) / without), without);
    EXPECT_GE(static_cast<double>(with), 0.98 * without);
    EXPECT_LE(without - static_cast<double>(with), printed + 1) << "more than the plan says";
  }
}

}  // namespace
}  // namespace lcrig
