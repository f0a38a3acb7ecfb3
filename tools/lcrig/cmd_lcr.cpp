// SPDX-License-Identifier: Apache-2.0
// lcr correct, show.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>
#include <system_error>

#include "base/text.hpp"
#include "storage/corrections.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/follow_run.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

Outcome<MeterCorrections> corrections_in(const json& answer) {
  auto meter = read_corrections(answer);
  if (!meter) return Failure(kUnreachable, "the daemon's answer names no meter", "lcrig doctor");
  return *meter;
}

void print_corrections(std::ostream& out, const MeterCorrections& meter, std::int64_t now_unix_ns) {
  const auto words = [now_unix_ns](const CorrectionState& state) {
    return printable(correction_words(state, now_unix_ns, "ago"), kLongestWords);
  };
  fmt::print(out, "{}{}\n", printable(meter.meter, kLongestName),
             meter.simulated ? " (simulated)" : "");
  fmt::print(out, "open   {}\nshort  {}\n", words(meter.open), words(meter.short_circuit));
}

class LcrCorrectCommand final : public Command {
 public:
  LcrCorrectCommand()
      : Command("lcr correct", "Make the meter's open or short correction, and store when",
                "lcrig lcr correct open") {}
  void declare(ArgumentList& list) override {
    list.positional({"KIND", Proposes::correction}, word_,
                    "open: nothing between the probes; short: probes joined");
    list.flag("--yes", prepared_, "The probes are prepared: do not ask");
  }

  Outcome<ExitCode> run(Context& context) override {
    const auto kind = parse_word<CorrectionKind>(word_);
    if (!kind) {
      return Failure(kUsage, fmt::format("KIND '{}': it takes open or short", printable(word_)),
                     "lcrig lcr correct --help");
    }
    auto client = ControlClient::connect(context);
    if (!client) return without_rehearsal(client.error());
    if (auto ready = wait_for_person(context, *kind); !ready) return ready.error();
    StopSignals signals;
    client->leave_on(signals.fd());
    context.console.note(
        "if it is accepted, the meter measures at all its frequencies: up to two minutes");
    constexpr Duration kLongest = std::chrono::seconds(200);
    auto answer = client->call("lcr.correct", json{{"kind", word_}}, kLongest);
    signals.take();  // unless taken, the signal would end this process before it prints
    if (!answer) return not_made(context, answer.error());
    auto meter = corrections_in(*answer);
    if (!meter) return meter.error();
    return show(context, *answer, [&](std::ostream& out) {
      fmt::print(out, "the {} correction is made and on, and stored\n", word_);
      print_corrections(out, *meter, context.clock.unix_ns());
      tell_next(context, *meter, *kind);
    });
  }

 private:
  Outcome<bool> wait_for_person(Context& context, CorrectionKind kind) const {
    if (prepared_) return true;
    const auto again = next_command(context.global, {"lcr", "correct", word_, "--yes"},
                                    "once the probes are prepared");
    if (!context.console.in_tty) {
      return Failure(kUsage, "nobody is at a terminal to say that the probes are prepared", again);
    }
    const char* const how =
        kind == CorrectionKind::open
            ? "Take the specimen away: leads and probes as in a run, and nothing between them."
            : "Join the probes with a piece of metal: leads as in a run, and nothing else there.";
    const auto line =
        context.console.wait_for_line(fmt::format("{} Press Enter when it is so. ", how));
    if (!line) return Failure(kInterrupted, "nobody said so: nothing was done", again);
    if (line->empty() || *line == "y" || *line == "yes") return true;
    return Failure(kFailed,
                   fmt::format("'{}' is no yes: nothing was done", printable(*line, kLongestName)),
                   again);
  }

  Failure not_made(const Context& context, Failure why) const {
    if (why.code == kInterrupted) {
      return Failure(kInterrupted,
                     "left: the meter goes on; the correction will be stored; make it again when "
                     "something lay between the probes",
                     next_command(context.global, {"lcr"}, "what is stored, in two minutes"));
    }
    if (why.code == kInstrument) {
      why.next = "see to what the message names, then: " +
                 next_command(context.global, {"lcr", "correct", word_});
    }
    return why;
  }

  static void tell_next(Context& context, MeterCorrections& meter, CorrectionKind made) {
    const auto other =
        made == CorrectionKind::open ? CorrectionKind::short_circuit : CorrectionKind::open;
    const CorrectionState& state = meter.of(other);
    if (state.on.value_or(true) && state.made_unix_ns) return;
    context.console.next(
        next_command(context.global, {"lcr", "correct", std::string(to_string(other))}));
  }

  std::string word_;
  bool prepared_ = false;
};

Outcome<MeterCorrections> ask(const Context& context) {
  auto answer = call_daemon(context, "lcr.show", json::object(), std::chrono::minutes(1));
  if (!answer) return answer.error();
  return corrections_in(*answer);
}

Outcome<std::vector<MeterCorrections>> stored(const Context& context) {
  auto path = context.db_path();
  if (!path) return path.error();
  std::error_code ignored;
  // A missing default database is normal at first. A missing database that a person named is a
  // mistake, and opening it reports that.
  if (context.global.db.empty() && !std::filesystem::exists(*path, ignored)) {
    return std::vector<MeterCorrections>();
  }
  auto db = open_runs(context);
  if (!db) return db.error();
  auto meters = list_corrections(*db);
  if (!meters) return Failure(meters.error());
  return *meters;
}

// Without a daemon, or during a run, the database still tells when the corrections were made.
Outcome<ExitCode> lcr_show(Context& context, const std::string&) {
  auto meters = stored(context);
  if (!meters) return meters.error();
  auto asked = ask(context);
  if (asked) {
    std::erase_if(*meters, [&](const auto& one) { return one.meter == asked->meter; });
    meters->insert(meters->begin(), *asked);
  }
  const std::string why_not = asked ? "" : asked.error().what;
  json all{{"asked", asked.has_value()}, {"why_not", why_not}, {"meters", json::array()}};
  for (const auto& meter : *meters) all["meters"].push_back(to_json(meter));
  if (!asked) context.console.note("the meter was not asked: " + why_not);
  return show(context, all, [&](std::ostream& out) {
    for (const auto& meter : *meters) print_corrections(out, meter, context.clock.unix_ns());
    if (meters->empty()) fmt::print(out, "no correction was made through lcrig\n");
  });
}

constexpr OneWord kLcrShow{"lcr show",
                           "The meter's open and short correction: on or off, and how old",
                           "lcrig lcr show", lcr_show};

}  // namespace

const CommandFactory kLcrCorrectCommand = make_command<LcrCorrectCommand>;
const CommandFactory kLcrShowCommand = make_command<OneWordCommand, kLcrShow>;

}  // namespace lcrig::cli
