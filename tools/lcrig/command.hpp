// SPDX-License-Identifier: Apache-2.0
// The base class of all subcommands: what each takes, as data, and what it does. Only parser.cpp
// knows CLI11.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "base/time.hpp"
#include "protocols/file/parse.hpp"
#include "tools/lcrig/cmd_rehearse.hpp"
#include "tools/lcrig/console.hpp"
#include "tools/lcrig/process_env.hpp"

namespace lcrig::cli {

inline constexpr const char* kUsualBench = "paper";

// Options that every command takes.
struct GlobalOptions {
  std::string db, socket, config;  // empty: not given
  bool json = false;
};

// What the shells' completion proposes for a value.
enum class Proposes {
  nothing,
  file,
  json_file,
  folder,
  protocol,  // of the library, or a file
  specimen,  // of the library or the database, or a file
  bench,  // of the library, or a file
  parameter,  // of the protocol that stands before it
  run,
  run_specimen,  // that a run was made with
  run_protocol,
  operator_name,  // of a run
  tag,
  batch,
  entry,  // of the queue
  correction,  // of the meter
};

// What stands for a value in help and manual: "FILE".
struct Placeholder {
  constexpr Placeholder(const char* w, Proposes p = Proposes::nothing) : word(w), proposes(p) {}
  const char* word;
  Proposes proposes;
};
inline constexpr Placeholder kRunWord{"RUN", Proposes::run}, kFileWord{"FILE", Proposes::file},
    kJsonFileWord{"FILE", Proposes::json_file}, kProtocolWord{"PROTOCOL", Proposes::protocol},
    kSpecimenWord{"S", Proposes::specimen}, kBenchWord{"B", Proposes::bench},
    kParameterWord{"NAME=VALUE", Proposes::parameter}, kEntryWord{"ENTRY", Proposes::entry},
    kTagWord{"TAG", Proposes::tag}, kOperatorWord{"NAME", Proposes::operator_name};

// Where a command declares what it takes. Names as CLI11 writes them ("-p,--parameter"); the
// variables must live until the command ran.
class ArgumentList {
 public:
  virtual ~ArgumentList() = default;
  virtual void positional(Placeholder name, std::string& out, const char* help,
                          bool required = true) = 0;
  // Any number of them; what is there already stays when none is given.
  virtual void words(Placeholder name, std::vector<std::string>& out, const char* help,
                     bool required = false) = 0;
  virtual void option(const char* names, std::string& out, Placeholder value, const char* help,
                      bool required = false) = 0;
  virtual void options(const char* names, std::vector<std::string>& out, Placeholder value,
                       const char* help) = 0;  // may be repeated
  virtual void seed(const char* names, std::optional<std::uint64_t>& out, const char* help) = 0;
  virtual void number(const char* names, std::function<void(double)> take, const char* metavar,
                      const char* help) = 0;
  // `T`: double, or an optional of it. Without the option `out` stays as it is.
  template <class T>
    requires std::is_assignable_v<T&, double>
  void number(const char* names, T& out, const char* metavar, const char* help) {
    number(names, std::function<void(double)>([&out](double value) { out = value; }), metavar,
           help);
  }
  virtual void one_of(const char* names, std::string& out, const std::vector<std::string>& choices,
                      const char* help) = 0;
  virtual void flag(const char* names, bool& out, const char* help) = 0;
};

// Answers the words that only the build and the shells use and no help shows; nullopt: a person's
// command.
std::optional<std::string> answer_to_program(const ProcessEnv& env,
                                             const std::vector<std::string>& args);

void declare_global(ArgumentList& list, GlobalOptions& global);

// The database file of a command.
struct ChosenDatabase {
  std::string path;
  // The daemon has this database: only the daemon may write, so commands ask it to. True also of
  // the service's file while no daemon answers.
  bool daemon_writes = false;
  // Why the daemon that was named, or whose socket is there, did not say which database it has: it
  // may be another one. Nothing when the file was named.
  std::optional<Failure> unsure;
};

// The surroundings of a command. References outlive it.
struct Context {
  Context(Console& c, const ProcessEnv& e, const Clock& k, DaemonParts d)
      : console(c), env(e), clock(k), daemon(d) {}
  Console& console;
  const ProcessEnv& env;
  const Clock& clock;
  DaemonParts daemon;
  GlobalOptions global;

  // The file that was named: by --db, --config, or, where the command line names no daemon either,
  // $LCRIG_DB. Else the daemon's; without a daemon the default of ProcessEnv. Asks the daemon once,
  // and says what a person might not expect.
  Outcome<ChosenDatabase> database() const;
  // For a command that writes. Failure: also unreachable, when `database` would do without the
  // daemon that was asked; and when somebody records into the file that was named. `typed`: the
  // words of the command, without options that say where.
  Outcome<ChosenDatabase> database_to_write(const std::vector<std::string>& typed) const;
  Outcome<std::string> db_path() const;  // of `database`
  // --socket, else "socket" of --config, else the default of ProcessEnv.
  Outcome<std::string> socket_path() const;
  // The file that was named, as for `database`; nullopt: none was.
  Outcome<std::optional<std::string>> named_db() const;

 private:
  Outcome<ChosenDatabase> choose_database() const;
  ChosenDatabase without_daemon(const std::string& socket, const Failure& why) const;
  mutable std::optional<ChosenDatabase> chosen_;
  mutable bool told_unsure_ = false;
};

class Command {
 public:
  // `words`: "run", "protocol list". The example is a whole line that can be typed.
  Command(const char* words, const char* what_for, const char* typed)
      : name(words), summary(what_for), example(typed) {}
  virtual ~Command() = default;
  virtual void declare(ArgumentList&) {}
  virtual Outcome<ExitCode> run(Context& context) = 0;

  const char *const name, *const summary, *const example;
};

// A command that takes a word or none.
struct OneWord {
  const char *name, *summary, *example;
  Outcome<ExitCode> (*run)(Context& context, const std::string& word);
  Placeholder placeholder = "";
  const char* help = nullptr;  // nullptr: it takes none
  bool required = true;
};
class OneWordCommand final : public Command {
 public:
  explicit OneWordCommand(const OneWord& row)
      : Command(row.name, row.summary, row.example), row_(row) {}
  void declare(ArgumentList& list) override {
    if (row_.help != nullptr) list.positional(row_.placeholder, word_, row_.help, row_.required);
  }
  Outcome<ExitCode> run(Context& context) override { return row_.run(context, word_); }

 private:
  const OneWord& row_;
  std::string word_;
};

using CommandFactory = std::unique_ptr<Command> (*)();
template <class C>
std::unique_ptr<Command> make_command() {
  return std::make_unique<C>();
}
// The same for a class whose commands are rows of a table.
template <class C, const auto& row>
std::unique_ptr<Command> make_command() {
  return std::make_unique<C>(row);
}

// Every command of `lcrig`, in the order of the help.
std::vector<std::unique_ptr<Command>> make_commands();

// "name=value" of every -p for this protocol. Failure: usage.
Outcome<ParameterValues> parse_assignments(const std::string& protocol,
                                           const std::vector<std::string>& words);
std::string login_name();

// Runs the program. `args` without its name. Prints failures; returns the exit code.
int run_cli(const std::vector<std::string>& args, Context& context);

}  // namespace lcrig::cli
