// SPDX-License-Identifier: Apache-2.0
// queue add, move, remove, clear, hold, start, lock, unlock, answer: what changes the queue.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/next_command.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/protocol_request.hpp"
#include "tools/lcrig/queue_request.hpp"
#include "tools/lcrig/queue_terms.hpp"

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
  // One run, or a table of runs.
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
    if (auto ok = place_.put_into(params, context.global); !ok) return ok.error();
    const std::int64_t now_unix_s = context.clock.unix_ns() / 1'000'000'000;
    if (auto ok = terms_.put_into(params, now_unix_s); !ok) return ok.error();
    return queue_batch(context, params, *batch);
  }

  Outcome<json> request(const Context& context) const {
    auto run = run_request(LibraryPath(context.env), protocol_, parameters_, specimen_);
    if (!run) return run.error();
    run->operator_name = operator_;
    run->note = note_;
    json out = to_json(*run);
    if (auto ok = place_.put_into(out, context.global); !ok) return ok.error();
    const std::int64_t now_unix_s = context.clock.unix_ns() / 1'000'000'000;
    if (auto ok = terms_.put_into(out, now_unix_s); !ok) return ok.error();
    return out;
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

class QueueRemoveCommand final : public Command {
 public:
  QueueRemoveCommand()
      : Command("queue remove", "Take an entry out of the queue", "lcrig queue remove 7") {}
  void declare(ArgumentList& list) override {
    list.positional(kEntryWord, entry_, "Its number in `lcrig queue list`");
  }
  Outcome<ExitCode> run(Context& context) override {
    auto entry = entry_number(entry_, context.global);
    if (!entry) return entry.error();
    return call_queue(context, "queue.remove", json{{"entry", *entry}},
                      [&](std::ostream& out, const json&) {
                        fmt::print(out, "entry {} is out of the queue\n", *entry);
                      });
  }

 private:
  std::string entry_;
};

class QueueClearCommand final : public Command {
 public:
  QueueClearCommand()
      : Command("queue clear", "Take everything out that does not run", "lcrig queue clear") {}
  Outcome<ExitCode> run(Context& context) override {
    return call_queue(
        context, "queue.clear", json::object(), [](std::ostream& out, const json& answer) {
          const auto removed = answer.value("removed", std::int64_t{0});
          fmt::print(out, "{} out of the queue\n",
                     removed == 1 ? "1 entry is" : fmt::format("{} entries are", removed));
        });
  }
};

class QueueHoldCommand final : public Command {
 public:
  QueueHoldCommand()
      : Command("queue hold", "Begin nothing more; a run that goes on is finished",
                "lcrig queue hold --why lunch") {}
  void declare(ArgumentList& list) override {
    list.option("--why", why_, "TEXT", "Shown to whoever looks");
  }
  Outcome<ExitCode> run(Context& context) override {
    json params = json::object();
    if (!why_.empty()) params["why"] = why_;
    return call_queue(context, "queue.hold", params, [&](std::ostream& out, const json&) {
      fmt::print(out, "the queue is held\n");
      context.console.next(next_command(context.global, {"queue", "start"}, "goes on"));
    });
  }

 private:
  std::string why_;
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

class QueueLockCommand final : public Command {
 public:
  QueueLockCommand()
      : Command("queue lock", "Nobody but you changes the queue from now on",
                "lcrig queue lock --why \"series of Ada\"") {}
  void declare(ArgumentList& list) override {
    list.option("--why", why_, "TEXT", "Shown to whoever is refused");
  }
  Outcome<ExitCode> run(Context& context) override {
    json params = json::object();
    if (!why_.empty()) params["why"] = why_;
    return call_queue(context, "queue.lock", params, [&](std::ostream& out, const json&) {
      fmt::print(out, "locked; everybody may still hold it, and answer at a gate\n");
      context.console.next(next_command(context.global, {"queue", "unlock"}));
    });
  }

 private:
  std::string why_;
};

class QueueUnlockCommand final : public Command {
 public:
  QueueUnlockCommand()
      : Command("queue unlock", "Everybody may change the queue again", "lcrig queue unlock") {}
  void declare(ArgumentList& list) override {
    list.flag("--force", force_, "Also a lock of somebody else; the history says so");
  }
  Outcome<ExitCode> run(Context& context) override {
    json params = json::object();
    if (force_) params["force"] = true;
    return call_queue(context, "queue.unlock", params,
                      [](std::ostream& out, const json&) { fmt::print(out, "unlocked\n"); });
  }

 private:
  bool force_ = false;
};

class QueueAnswerCommand final : public Command {
 public:
  QueueAnswerCommand()
      : Command("queue answer", "Say that what a gate asks for is done: type the word it names",
                "lcrig queue answer paper-2") {}
  void declare(ArgumentList& list) override {
    list.positional("WORD", word_, "The name of the specimen that is on the rig, or yes");
  }
  Outcome<ExitCode> run(Context& context) override {
    return call_queue(
        context, "queue.answer", json{{"text", word_}},
        [](std::ostream& out, const json&) { fmt::print(out, "the queue goes on\n"); });
  }

 private:
  std::string word_;
};

}  // namespace

const CommandFactory kQueueAddCommand = make_command<QueueAddCommand>;
const CommandFactory kQueueMoveCommand = make_command<QueueMoveCommand>;
const CommandFactory kQueueRemoveCommand = make_command<QueueRemoveCommand>;
const CommandFactory kQueueClearCommand = make_command<QueueClearCommand>;
const CommandFactory kQueueHoldCommand = make_command<QueueHoldCommand>;
const CommandFactory kQueueStartCommand = make_command<QueueStartCommand>;
const CommandFactory kQueueLockCommand = make_command<QueueLockCommand>;
const CommandFactory kQueueUnlockCommand = make_command<QueueUnlockCommand>;
const CommandFactory kQueueAnswerCommand = make_command<QueueAnswerCommand>;

}  // namespace lcrig::cli
