// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <ranges>
#include <string_view>
#include <utility>

#include "base/text.hpp"
#include "model/specimen_file.hpp"
#include "protocols/file/parse.hpp"
#include "storage/batches.hpp"
#include "storage/database.hpp"
#include "storage/queue.hpp"
#include "storage/runs.hpp"
#include "storage/specimens.hpp"
#include "tools/lcrig/argument_table.hpp"
#include "tools/lcrig/library_path.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

namespace {

// Most names that are proposed, the newest first; nobody reads more.
constexpr std::int64_t kMostProposed = 100;

struct Candidates {
  std::string files = "none";
  std::map<std::string, std::string> words;  // the word, and what it is

  void add(const std::string& word, const std::string& what) { words.emplace(word, what); }
};

// The command line up to the word that is to be completed.
struct Typed {
  Command* command = nullptr;
  std::string group;  // as "queue" without its verb
  bool unknown = false;  // no command begins with this word
  std::vector<std::string> positionals;
  const Argument* awaits_value = nullptr;  // the option whose value the word is
  std::string db;
};

class Completion {
 public:
  Completion(const ProcessEnv& env, const std::vector<std::string>& words);
  std::string text() const;

 private:
  void read(const std::vector<std::string>& before);
  void read_word(const std::string& word);
  const Argument* find_option(std::string_view name) const;
  void set_command(Command& command);

  void complete_word(const std::string& word);
  void add_commands();
  void add_options();
  void add_values(const Argument& argument);
  void add_library_or_file(LibraryKind kind);
  void add_specimens();
  void add_runs();
  void add_of_runs(const std::string& words);
  void add_batches();
  void add_entries();
  void add_parameters();
  std::optional<Database> database() const;

  const ProcessEnv& env_;
  LibraryPath library_;
  std::vector<std::unique_ptr<Command>> commands_ = make_commands();
  std::vector<Argument> global_ = global_arguments();
  std::vector<Argument> arguments_;  // of the command
  Typed typed_;
  Candidates candidates_;
  std::string prefix_;  // what stands before the value in the same word: "--db="
};

Completion::Completion(const ProcessEnv& env, const std::vector<std::string>& words)
    : env_(env), library_(env) {
  if (words.empty()) return;
  read({words.begin(), words.end() - 1});
  complete_word(words.back());
}

const Argument* Completion::find_option(std::string_view name) const {
  for (const auto* list : {&arguments_, &global_}) {
    for (const auto& a : *list) {
      if (a.option && std::ranges::find(a.names, name) != a.names.end()) return &a;
    }
  }
  return nullptr;
}

void Completion::set_command(Command& command) {
  typed_.command = &command;
  arguments_ = arguments_of(command);
}

void Completion::read_word(const std::string& word) {
  if (typed_.command != nullptr) {
    typed_.positionals.push_back(word);
    return;
  }
  if (word == "help" && typed_.group.empty()) return;  // `lcrig help run`
  const auto name = typed_.group.empty() ? word : typed_.group + " " + word;
  for (const auto& command : commands_) {
    if (command->name == name) return set_command(*command);
  }
  const auto in_group = [&name](const auto& command) {
    return std::string_view(command->name).starts_with(name + " ");
  };
  typed_.unknown = !typed_.group.empty() || std::ranges::none_of(commands_, in_group);
  if (!typed_.unknown) typed_.group = word;
}

void Completion::read(const std::vector<std::string>& before) {
  for (const auto& word : before) {
    if (typed_.awaits_value != nullptr) {
      if (typed_.awaits_value->names.front() == "--db") typed_.db = word;
      typed_.awaits_value = nullptr;
    } else if (word.size() < 2 || word[0] != '-') {
      read_word(word);
    } else if (word.starts_with("--db=")) {
      typed_.db = word.substr(5);
    } else if (const Argument* option = find_option(word); option && !option->value.empty()) {
      typed_.awaits_value = option;
    }
  }
}

void Completion::complete_word(const std::string& word) {
  if (typed_.unknown) return;
  if (typed_.awaits_value != nullptr) return add_values(*typed_.awaits_value);
  const auto equals = word.find('=');
  if (word.starts_with("--") && equals != std::string::npos) {
    prefix_ = word.substr(0, equals + 1);
    if (const Argument* option = find_option(word.substr(0, equals))) add_values(*option);
    return;
  }
  if (word.starts_with("-")) return add_options();
  if (typed_.command == nullptr) return add_commands();
  std::size_t place = 0;
  for (const auto& a : arguments_) {
    if (a.option) continue;
    if (place++ == typed_.positionals.size() || a.repeats) return add_values(a);
  }
}

void Completion::add_commands() {
  for (const auto& command : commands_) {
    const std::string name = command->name;
    const auto space = name.find(' ');
    const auto first = name.substr(0, space);
    if (typed_.group.empty() && space == std::string::npos) {
      candidates_.add(first, command->summary);
    } else if (typed_.group.empty()) {  // a group is described by its verbs, as in the help
      auto& what = candidates_.words[first];
      what += (what.empty() ? "" : ", ") + name.substr(space + 1);
    } else if (first == typed_.group) {
      candidates_.add(name.substr(space + 1), command->summary);
    }
  }
}

void Completion::add_options() {
  for (const auto* list : {&arguments_, &global_}) {
    for (const auto& a : *list) {
      if (!a.option) continue;
      for (const auto& name : a.names) candidates_.add(name, a.help);
    }
  }
  candidates_.add("--help", "What the command takes, with an example");
}

void Completion::add_values(const Argument& a) {
  for (const auto& choice : a.choices) candidates_.add(choice, "");
  switch (a.proposes) {
    case Proposes::nothing: break;
    case Proposes::file: candidates_.files = "file"; break;
    case Proposes::json_file: candidates_.files = "json"; break;
    case Proposes::folder: candidates_.files = "dir"; break;
    case Proposes::protocol: return add_library_or_file(LibraryKind::protocol);
    case Proposes::bench: return add_library_or_file(LibraryKind::bench);
    case Proposes::specimen: add_library_or_file(LibraryKind::specimen); return add_specimens();
    case Proposes::parameter: return add_parameters();
    case Proposes::run: return add_runs();
    case Proposes::run_specimen: return add_of_runs("SELECT specimen_name, max(id) FROM run");
    case Proposes::run_protocol: return add_of_runs("SELECT protocol_name, max(id) FROM run");
    case Proposes::operator_name: return add_of_runs("SELECT operator, max(id) FROM run");
    case Proposes::tag: return add_of_runs("SELECT tag, max(run) FROM v_tag");
    case Proposes::batch: return add_batches();
    case Proposes::entry: return add_entries();
    case Proposes::correction:
      candidates_.add("open", "nothing between the probes");
      candidates_.add("short", "probes joined");
      break;
  }
}

void Completion::add_library_or_file(LibraryKind kind) {
  for (const auto& file : library_.list(kind)) candidates_.add(file.name, file.path.string());
  candidates_.files = "json";
}
void Completion::add_specimens() {
  for (const auto& s : shipped_specimens()) candidates_.add(std::string(s.name), "ships");
  const auto db = database();
  if (!db) return;
  const auto stored = list_specimens(*db);
  if (!stored) return;
  for (const auto& s : *stored) candidates_.add(s.name, "in the database");
}

void Completion::add_runs() {
  candidates_.add("last", "the newest run");
  const auto db = database();
  if (!db) return;
  const auto runs = list_runs(*db);
  if (!runs) return;
  for (const auto& r : *runs | std::views::take(kMostProposed)) {
    candidates_.add(std::to_string(r.run),
                    fmt::format("{} on {}, {}, {}", r.protocol_name, r.specimen_name, status_of(r),
                                format_utc(true_time_ns(r))));
  }
}

void Completion::add_batches() {
  const auto db = database();
  if (!db) return;
  const auto batches = list_batches(*db);
  if (!batches) return;
  for (const auto& b : *batches) candidates_.add(b.name, format_utc(b.added_unix_ns));
}

// Adds names from runs. `words` is SQL that selects each name with the newest run that has it. A
// database of an older schema may have none.
void Completion::add_of_runs(const std::string& words) {
  const auto db = database();
  if (!db) return;
  const auto found = db->rows(
      words + " GROUP BY 1 ORDER BY 2 DESC LIMIT ?",
      [](const Statement& s) { return std::pair(std::string(s.text(0)), s.integer(1)); },
      std::int64_t{kMostProposed});
  if (!found) return;
  for (const auto& [name, run] : *found) candidates_.add(name, fmt::format("as in run {}", run));
}

void Completion::add_entries() {
  const auto db = database();
  if (!db) return;
  const auto entries = list_queue(*db, 0, kMostProposed);
  if (!entries) return;
  for (const auto& e : *entries) {
    candidates_.add(std::to_string(e.entry),
                    fmt::format("{} on {}", e.protocol_name, e.specimen_name));
  }
}

void Completion::add_parameters() {
  if (typed_.positionals.empty()) return;
  const auto file = library_.find(LibraryKind::protocol, typed_.positionals.front());
  if (!file || !*file) return;
  const auto protocol = parse_protocol((*file)->text, typed_.positionals.front());
  if (!protocol) return;
  for (const auto& [name, p] : protocol->parameters) {
    candidates_.add(name + "=", fmt::format("{} to {}, default {}; {}", p.min, p.max,
                                            p.default_value, p.description));
  }
}

// The daemon is not asked, because its answer might take too long for a completion.
std::optional<Database> Completion::database() const {
  auto db = open_read_only(typed_.db.empty() ? env_.default_db().string() : typed_.db);
  if (!db) return std::nullopt;
  return std::move(*db);
}

std::string Completion::text() const {
  constexpr std::size_t kLongestWhat = 80;
  std::string out = candidates_.files + "\n";
  for (const auto& [word, what] : candidates_.words) {
    // Each line holds one word, so a word with a control character in it cannot be offered.
    if (printable(word, word.size()) != word) continue;
    out += fmt::format("{}{}\t{}\n", prefix_, word, printable(what, kLongestWhat));
  }
  return out;
}

}  // namespace

std::string complete(const ProcessEnv& env, const std::vector<std::string>& words) {
  return Completion(env, words).text();
}

}  // namespace lcrig::cli
