// SPDX-License-Identifier: Apache-2.0
// `lcrig watch`: shows the current run. `lcrig watch replay`: judges stored runs again with the
// watch of this program, and compares that with what the runs recorded, or with another program.
// `lcrig watch checks`: the table of its checks.
#include "tools/lcrig/cmd_watch.hpp"

#include <fmt/ostream.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "daemon/replayed_watch.hpp"
#include "events/event_words.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/run_database.hpp"
#include "tools/lcrig/watch_checks.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

constexpr std::string_view kReplay = "replay", kChecks = "checks";

json findings_json(const std::vector<WatchFinding>& findings, MonoTime started) {
  json out = json::array();
  for (const WatchFinding& f : findings) {
    out.push_back(
        {{"t_s", to_seconds(f.at - started)}, {"kind", to_string(f.kind)}, {"why", f.why}});
  }
  return out;
}

json to_json(const ReplayedWatch& r) {
  return {{"run", r.run},
          {"samples", r.samples},
          {"inputs", r.inputs},
          {"only", r.only},
          {"same", r.is_same()},
          {"recorded", findings_json(r.recorded, r.started)},
          {"judged", findings_json(r.judged, r.started)}};
}

void print_findings(std::ostream& out, const char* who, const std::vector<WatchFinding>& findings,
                    MonoTime started) {
  for (const WatchFinding& f : findings) {
    fmt::print(out, "  {:<9} {:>10.3f} s  {:<18} {}\n", who, to_seconds(f.at - started),
               to_string(f.kind), printable(event_words(f.why)));
  }
}

void print_run(std::ostream& out, const ReplayedWatch& r) {
  const std::string verdict = !r.is_same()       ? "other findings than recorded"
                              : r.judged.empty() ? "nothing found, as recorded"
                                                 : fmt::format("{} as recorded", r.judged.size());
  fmt::print(out, "run {}: {} samples, {} inputs: {}\n", r.run, r.samples, r.inputs, verdict);
  if (!r.only.empty()) fmt::print(out, "  {}\n", r.only);
  if (!r.is_same()) print_findings(out, "recorded", r.recorded, r.started);
  print_findings(out, "judged", r.judged, r.started);
}

struct CloseProgram {
  void operator()(std::FILE* pipe) const { ::pclose(pipe); }
};

// What `program watch replay --json` prints. Failure: it prints no JSON.
Outcome<json> ask_program(const std::string& program, const std::string& db,
                          const std::vector<std::int64_t>& runs) {
  std::string line = shell_quoted(program) + " --db " + shell_quoted(db) + " --json watch replay";
  for (const std::int64_t run : runs) line += fmt::format(" {}", run);
  const std::unique_ptr<std::FILE, CloseProgram> pipe(::popen(line.c_str(), "re"));
  std::string text;
  char buffer[4096];
  for (std::size_t n = 0; pipe && (n = std::fread(buffer, 1, sizeof buffer, pipe.get())) > 0;) {
    text.append(buffer, n);
  }
  json said = json::parse(text, nullptr, false);
  if (said.is_array() && said.size() == runs.size()) return said;
  return Failure(kFailed, fmt::format("{}: it did not judge the runs (above)", program),
                 "name a `lcrig` that knows `watch replay`");
}

class WatchCommand final : public Command {
 public:
  WatchCommand()
      : Command(
            "watch",
            "Show the run in progress until it ends; `replay RUN ...`: judge stored runs again; "
            "`checks`: what is checked, and with what tolerances",
            "lcrig watch replay last") {}
  void declare(ArgumentList& list) override {
    list.words(kRunWord, words_,
               "After the word `replay`: the runs to judge again, numbers, uuids, or `last`");
    list.option("--against", against_, kFileWord,
                "Compare with what another build of lcrig finds, not with what was recorded");
  }

  Outcome<ExitCode> run(Context& context) override {
    if (words_.empty() && against_.empty()) return watch_live(context);
    if (words_.size() == 1 && words_.front() == kChecks && against_.empty()) {
      return show(context, checks_json(), [](std::ostream& out) { out << checks_text(); });
    }
    if (words_.empty() || words_.front() != kReplay) {
      return Failure(kUsage,
                     words_.empty()
                         ? "--against is for `watch replay`"
                         : fmt::format("'{}' is nothing that watch knows", words_.front()),
                     next_command(context.global, {"watch", "replay", "last"}));
    }
    words_.erase(words_.begin());
    if (words_.empty()) words_.emplace_back("last");
    return replay(context);
  }

 private:
  Outcome<ExitCode> replay(Context& context) const {
    auto db = open_runs(context);
    if (!db) return db.error();
    std::vector<ReplayedWatch> replayed;
    std::vector<std::int64_t> numbers;
    for (const std::string& word : words_) {
      auto number = named_run(context, *db, word);
      if (!number) return number.error();
      auto one = replay_watch(*db, *number);
      if (!one) return Failure(one.error(), next_after(one.error()));
      numbers.push_back(*number);
      replayed.push_back(std::move(*one));
    }
    json all = json::array();
    for (const ReplayedWatch& r : replayed) all.push_back(to_json(r));
    if (!against_.empty()) return compare(context, *db, numbers, all);
    const bool same = std::ranges::all_of(replayed, &ReplayedWatch::is_same);
    const auto text = [&replayed](std::ostream& out) {
      for (const ReplayedWatch& r : replayed) print_run(out, r);
    };
    static_cast<void>(show(context, all, text));
    return same ? kOk : kFailed;
  }

  Outcome<ExitCode> compare(Context& context, const Database& db,
                            const std::vector<std::int64_t>& numbers, const json& here) const {
    auto there = ask_program(against_, db.path(), numbers);
    if (!there) return there.error();
    json out = json::array();
    bool same = true;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const json found = (*there)[i].value("judged", json::array());
      const bool equal = found == here[i]["judged"];
      same = same && equal;
      out.push_back(
          {{"run", numbers[i]}, {"same", equal}, {"here", here[i]["judged"]}, {"there", found}});
    }
    const auto text = [&out, this](std::ostream& to) {
      for (const json& run : out) {
        fmt::print(to, "run {}: {} as {}\n", run["run"].get<std::int64_t>(),
                   run["same"].get<bool>() ? "the same" : "other findings", against_);
        if (run["same"].get<bool>()) continue;
        for (const char* who : {"there", "here"}) {
          for (const json& f : run[who]) {
            fmt::print(to, "  {:<6} {:>10.3f} s  {:<18} {}\n", who, f["t_s"].get<double>(),
                       f["kind"].get<std::string>(),
                       printable(event_words(f["why"].get<std::string>())));
          }
        }
      }
    };
    static_cast<void>(show(context, out, text));
    return same ? kOk : kFailed;
  }

  std::vector<std::string> words_;
  std::string against_;
};

}  // namespace

const CommandFactory kWatchCommand = make_command<WatchCommand>;

}  // namespace lcrig::cli
