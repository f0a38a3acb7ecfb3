// SPDX-License-Identifier: Apache-2.0
// The base class of all subcommands: what each of them takes, as data, and what it does. Only
// parser.cpp depends on CLI11.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
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
  std::string db, socket, config;  // empty: the option was not given
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
  parameter,  // of the protocol that was typed before it
  run,
  run_specimen,  // a specimen with which a run was made
  run_protocol,
  operator_name,  // an operator of some run
  tag,
  batch,
  entry,  // of the queue
  correction,  // of the meter
};

// The word that stands for a value in help and manual, such as "FILE".
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

// Declares what a command takes. Names are written as for CLI11 ("-p,--parameter"). The variables
// must exist until the command has run.
class ArgumentList {
 public:
  virtual ~ArgumentList() = default;
  virtual void positional(Placeholder name, std::string& out, const char* help,
                          bool required = true) = 0;
  // Any number of words. When none is given, `out` keeps its content.
  virtual void words(Placeholder name, std::vector<std::string>& out, const char* help,
                     bool required = false) = 0;
  virtual void option(const char* names, std::string& out, Placeholder value, const char* help,
                      bool required = false) = 0;
  virtual void options(const char* names, std::vector<std::string>& out, Placeholder value,
                       const char* help) = 0;  // may be repeated
  virtual void seed(const char* names, std::optional<std::uint64_t>& out, const char* help) = 0;
  virtual void number(const char* names, std::function<void(double)> take, const char* metavar,
                      const char* help) = 0;
  // `T` is double or std::optional<double>. Without the option `out` stays as it is.
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

// Answers the hidden words that the build and the shells use. nullopt: it is an ordinary command.
std::optional<std::string> answer_to_program(const ProcessEnv& env,
                                             const std::vector<std::string>& args);

void declare_global(ArgumentList& list, GlobalOptions& global);

// The database file of a command.
struct ChosenDatabase {
  std::string path;
  // The daemon has this database. Only the daemon may write into it, so commands ask the daemon to.
  // Also true for the service's file while no daemon answers.
  bool daemon_writes = false;
  // Why a daemon did not say which database it has, although it was named or its socket exists. It
  // may be another database. Empty when the file was named.
  std::optional<Failure> unsure;
};

// What a command works with. The references must outlive it.
struct Context {
  Context(Console& c, const ProcessEnv& e, const Clock& k, DaemonParts d)
      : console(c), env(e), clock(k), daemon(d) {}
  Console& console;
  const ProcessEnv& env;
  const Clock& clock;
  DaemonParts daemon;
  GlobalOptions global;

  // The file that was named by --db, by --config, or by $LCRIG_DB if the command line names no
  // daemon. If no file was named: the daemon's, and without a daemon the default of ProcessEnv. The
  // daemon is asked once. Anything that a person might not expect is printed.
  Outcome<ChosenDatabase> database() const;
  // For commands that write. Failure: unreachable, if the daemon that was asked for does not answer
  // (`database` would do without it); or somebody records into the file that was named. `typed`:
  // the words of the command, without options that say where.
  Outcome<ChosenDatabase> database_to_write(const std::vector<std::string>& typed) const;
  Outcome<std::string> db_path() const;  // of `database`
  // --socket, or else "socket" of --config, or else the default of ProcessEnv.
  Outcome<std::string> socket_path() const;
  // The file that was named, as for `database`. nullopt: none was named.
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

// A command that takes one word or none.
struct OneWord {
  const char *name, *summary, *example;
  Outcome<ExitCode> (*run)(Context& context, const std::string& word);
  Placeholder placeholder = "";
  const char* help = nullptr;  // nullptr: it takes no word
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
// The same for a class of which each row of a table is a command.
template <class C, const auto& row>
std::unique_ptr<Command> make_command() {
  return std::make_unique<C>(row);
}

// Every command of `lcrig`, in the order of the help.
std::vector<std::unique_ptr<Command>> make_commands();

// "cycles=5" as its name and its value. nullopt: one of them is missing.
std::optional<std::pair<std::string, std::string>> split_assignment(const std::string& word);
// Parses the "name=value" of every -p for this protocol. Failure: usage.
Outcome<ParameterValues> parse_assignments(const std::string& protocol,
                                           const std::vector<std::string>& words);
std::string login_name();

// Runs the program. `args` excludes its name. Prints failures and returns the exit code.
int run_cli(const std::vector<std::string>& args, Context& context);

}  // namespace lcrig::cli
