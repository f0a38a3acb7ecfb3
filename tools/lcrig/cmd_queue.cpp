// SPDX-License-Identifier: Apache-2.0
// queue add, move, remove, clear, hold, start, lock, unlock, answer: what changes the queue.
#include <fmt/ostream.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/protocol_request.hpp"
#include "tools/lcrig/queue_request.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class QueueAddCommand final : public Command {
 public:
  QueueAddCommand()
      : Command("queue add", "Put a run into the queue; it is checked and planned",
                "lcrig queue add static-frame --specimen paper-1") {}
  void declare(ArgumentList& list) override {
    list.positional(kProtocolWord, protocol_, "Name or file; not with --batch", false);
    list.options("-p,--parameter", parameters_, kParameterWord, "Change a parameter");
    list.option("-s,--specimen", specimen_, kSpecimenWord, "Name or file of what will be pressed");
    list.option("--operator", operator_, kOperatorWord, "Who runs it (default: you)");
    list.option("--note", note_, "TEXT", "Stored with the run");
    batch_.declare(list);
    list.seed("--seed", seed_, "Of the order of a batch (default: one is drawn)");
    place_.declare(list);
    terms_.declare(list);
  }

  Outcome<ExitCode> run(Context& context) override {
    if (auto fits = check_words(); !fits) return fits.error();
    if (batch_.given()) return add_table(context);
    auto wanted = request(context);
    if (!wanted) return wanted.error();
    auto client = ControlClient::connect(context);
    if (!client) return client.error();
    RunRequest named;
    named.specimen_name = specimen_;
    return queue_run(context, *client, *wanted, named, protocol_, parameters_);
  }

 private:
  // Checks that either one run or a table of runs is asked for.
  Outcome<bool> check_words() const {
    const auto usage = [](const std::string& what) {
      return Failure(kUsage, "lcrig queue add: " + what, "lcrig queue add --help");
    };
    if (!batch_.given()) {
      if (const auto stray = batch_.stray(); !stray.empty()) {
        return usage(stray + " is for --batch FILE");
      }
      if (seed_) return usage("--seed is for --batch FILE");
      if (protocol_.empty()) return usage("PROTOCOL is missing");
      if (specimen_.empty()) return usage("--specimen is missing");
      return true;
    }
    const char* other = !protocol_.empty()     ? "PROTOCOL"
                        : !specimen_.empty()   ? "--specimen"
                        : !parameters_.empty() ? "-p"
                        : !note_.empty()       ? "--note"
                                               : nullptr;
    if (other == nullptr) return true;
    return usage(fmt::format("{} and --batch exclude each other: the table says it", other));
  }

  Outcome<ExitCode> add_table(Context& context) const {
    auto db = context.db_path();
    if (!db) return db.error();
    auto batch = batch_.read(context, *db, seed_);
    if (!batch) return batch.error();
    json params = batch_params(*batch);
    if (!operator_.empty()) params["operator"] = operator_;
    if (auto ok = put_into(params, context); !ok) return ok.error();
    return queue_batch(context, params, *batch);
  }

  Outcome<json> request(const Context& context) const {
    auto run = run_request(LibraryPath(context.env), protocol_, parameters_, specimen_);
    if (!run) return run.error();
    run->operator_name = operator_;
    run->note = note_;
    json out = to_json(*run);
    if (auto ok = put_into(out, context); !ok) return ok.error();
    return out;
  }

  // Adds the place in the queue and the terms.
  Outcome<bool> put_into(json& params, const Context& context) const {
    if (auto ok = place_.put_into(params, context.global); !ok) return ok.error();
    return terms_.put_into(params, context.clock.unix_ns() / kSecond_ns);
  }

  std::string protocol_, specimen_, operator_, note_;
  std::vector<std::string> parameters_;
  BatchOptions batch_;
  std::optional<std::uint64_t> seed_;
  PlaceOptions place_;
  TermsOptions terms_;
};

class QueueMoveCommand final : public Command {
 public:
  QueueMoveCommand()
      : Command("queue move", "Give an entry that waits another place",
                "lcrig queue move 7 --first") {}
  void declare(ArgumentList& list) override {
    list.positional(kEntryWord, entry_, "Its number in `lcrig queue list`");
    place_.declare(list);
  }
  Outcome<ExitCode> run(Context& context) override {
    auto entry = entry_number(entry_, context.global);
    if (!entry) return entry.error();
    if (!place_.given()) {
      return Failure(kUsage,
                     "where to? --first, --last, --before ENTRY or --after ENTRY is missing",
                     next_command(context.global, {"queue", "move", entry_, "--first"}));
    }
    json params{{"entry", *entry}};
    if (auto ok = place_.put_into(params, context.global); !ok) return ok.error();
    return call_queue(context, "queue.move", params, [&](std::ostream& out, const json&) {
      fmt::print(out, "entry {} moved\n", *entry);
      context.console.next(next_command(context.global, {"queue", "list"}));
    });
  }

 private:
  std::string entry_;
  PlaceOptions place_;
};

// A verb that is a single call of the daemon, and what it takes.
enum class QueueVerbTakes { nothing, entry, word, why, force };
struct QueueVerb {
  const char *name, *summary, *example;
  std::string (*done)(const json& params, const json& answer);  // what to print when it is done
  QueueVerbTakes takes = QueueVerbTakes::nothing;
  const char* help = "";  // help for what it takes
  const char *next = nullptr, *next_note = "";  // the queue verb to propose next
};

constexpr QueueVerb kQueueRemove{
    .name = "queue remove",
    .summary = "Take an entry out of the queue",
    .example = "lcrig queue remove 7",
    .done =
        [](const json& params, const json&) {
          return fmt::format("entry {} is out of the queue", params["entry"].get<std::int64_t>());
        },
    .takes = QueueVerbTakes::entry,
    .help = "Its number in `lcrig queue list`",
};
constexpr QueueVerb kQueueClear{
    .name = "queue clear",
    .summary = "Take everything out that does not run",
    .example = "lcrig queue clear",
    .done =
        [](const json&, const json& answer) {
          const auto n = answer.value("removed", std::int64_t{0});
          return n == 1 ? "1 entry is out of the queue"
                        : fmt::format("{} entries are out of the queue", n);
        },
};
constexpr QueueVerb kQueueHold{
    .name = "queue hold",
    .summary = "Begin nothing more; a run that goes on is finished",
    .example = "lcrig queue hold --why lunch",
    .done = [](const json&, const json&) { return std::string("the queue is held"); },
    .takes = QueueVerbTakes::why,
    .help = "Shown to whoever looks",
    .next = "start",
    .next_note = "goes on",
};
constexpr QueueVerb kQueueLock{
    .name = "queue lock",
    .summary = "Nobody but you changes the queue from now on",
    .example = "lcrig queue lock --why \"series of Ada\"",
    .done =
        [](const json&, const json&) {
          return std::string("locked; everybody may still hold it, and answer at a gate");
        },
    .takes = QueueVerbTakes::why,
    .help = "Shown to whoever is refused",
    .next = "unlock",
};
constexpr QueueVerb kQueueUnlock{
    .name = "queue unlock",
    .summary = "Everybody may change the queue again",
    .example = "lcrig queue unlock",
    .done = [](const json&, const json&) { return std::string("unlocked"); },
    .takes = QueueVerbTakes::force,
    .help = "Also a lock of somebody else; the history says so",
};
constexpr QueueVerb kQueueAnswer{
    .name = "queue answer",
    .summary = "Say that what a gate asks for is done: type the word it names",
    .example = "lcrig queue answer paper-2",
    .done = [](const json&, const json&) { return std::string("the queue goes on"); },
    .takes = QueueVerbTakes::word,
    .help = "The name of the specimen that is on the rig, or yes",
};

class QueueVerbCommand final : public Command {
 public:
  explicit QueueVerbCommand(const QueueVerb& verb)
      : Command(verb.name, verb.summary, verb.example), verb_(verb) {}
  void declare(ArgumentList& list) override {
    switch (verb_.takes) {
      case QueueVerbTakes::nothing: return;
      case QueueVerbTakes::entry: return list.positional(kEntryWord, text_, verb_.help);
      case QueueVerbTakes::word: return list.positional("WORD", text_, verb_.help);
      case QueueVerbTakes::why: return list.option("--why", text_, "TEXT", verb_.help);
      case QueueVerbTakes::force: return list.flag("--force", force_, verb_.help);
    }
  }
  Outcome<ExitCode> run(Context& context) override {
    json params = json::object();
    if (verb_.takes == QueueVerbTakes::entry) {
      auto entry = entry_number(text_, context.global);
      if (!entry) return entry.error();
      params["entry"] = *entry;
    }
    if (verb_.takes == QueueVerbTakes::word) params["text"] = text_;
    if (verb_.takes == QueueVerbTakes::why && !text_.empty()) params["why"] = text_;
    if (force_) params["force"] = true;
    std::string method = name;  // "queue.remove"
    std::ranges::replace(method, ' ', '.');
    return call_queue(context, method, params, [&](std::ostream& out, const json& answer) {
      fmt::print(out, "{}\n", verb_.done(params, answer));
      if (verb_.next == nullptr) return;
      context.console.next(next_command(context.global, {"queue", verb_.next}, verb_.next_note));
    });
  }

 private:
  const QueueVerb& verb_;
  std::string text_;
  bool force_ = false;
};

class QueueStartCommand final : public Command {
 public:
  QueueStartCommand()
      : Command("queue start", "Run what waits, one after the other", "lcrig queue start") {}
  void declare(ArgumentList& list) override {
    list.flag("--resume", resume_, "The interrupted entry goes on where its run stopped");
    list.flag("--repeat", repeat_, "The entry that failed or was interrupted begins anew");
    list.flag("--skip", skip_, "The entry that failed or was interrupted leaves the queue");
  }
  Outcome<ExitCode> run(Context& context) override {
    if (int{resume_} + int{repeat_} + int{skip_} > 1) {
      return Failure(kUsage, "--resume, --repeat and --skip exclude each other: give one",
                     "lcrig queue start --help");
    }
    json params = json::object();
    if (resume_) params["head"] = "resume";
    if (repeat_) params["head"] = "repeat";
    if (skip_) params["head"] = "skip";
    return call_queue(context, "queue.start", params, [&](std::ostream& out, const json&) {
      fmt::print(out, "the queue goes\n");
      context.console.next(
          next_command(context.global, {"queue", "list"}, "says what it waits for"));
    });
  }

 private:
  bool resume_ = false, repeat_ = false, skip_ = false;
};

}  // namespace

const CommandFactory kQueueAddCommand = make_command<QueueAddCommand>;
const CommandFactory kQueueMoveCommand = make_command<QueueMoveCommand>;
const CommandFactory kQueueRemoveCommand = make_command<QueueVerbCommand, kQueueRemove>;
const CommandFactory kQueueClearCommand = make_command<QueueVerbCommand, kQueueClear>;
const CommandFactory kQueueHoldCommand = make_command<QueueVerbCommand, kQueueHold>;
const CommandFactory kQueueStartCommand = make_command<QueueStartCommand>;
const CommandFactory kQueueLockCommand = make_command<QueueVerbCommand, kQueueLock>;
const CommandFactory kQueueUnlockCommand = make_command<QueueVerbCommand, kQueueUnlock>;
const CommandFactory kQueueAnswerCommand = make_command<QueueVerbCommand, kQueueAnswer>;

}  // namespace lcrig::cli
