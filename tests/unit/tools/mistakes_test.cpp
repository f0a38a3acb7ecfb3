// SPDX-License-Identifier: Apache-2.0
// Mistakes that people type and write, and the answers to them: tests/corpus/mistakes. Each
// THEME.txt has its answers in THEME.expected, so that a changed message shows up as a diff.
// LCRIG_WRITE_EXPECTED=1 writes the answers anew.
//
// Lines of a THEME.txt:
//   # a comment
//   file NAME            then its lines, until a line `end`
//   bytes NAME 7b 7d     a file that is not UTF-8
//   edit NAME: OLD => NEW    my.json: the shipped protocol NAME with OLD replaced
//   $ COMMAND            run in a folder that has these files
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "base/doc_page.hpp"
#include "daemon/config.hpp"
#include "daemon/session.hpp"
#include "storage/database.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/support/shell.hpp"

namespace lcrig {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  for (auto at = text.find(what); at != text.npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

// The commands in a `next:` line. The line is a command, or has one behind its last colon. A
// question in the parentheses after it has another one.
std::vector<std::string> proposed_in(const std::string& next) {
  const auto names_program = [](const std::string& text) {
    const auto program = text.substr(0, text.find(' '));
    const std::set<std::string> known{"lcrig", "lcrigd", "systemctl", "sudo", "mkdir", "df"};
    return known.contains(program);
  };
  std::vector<std::string> out;
  const auto note = std::min(next.find("   ("), next.size());
  const auto head = next.substr(0, note);
  const auto colon = head.rfind(": ");
  if (names_program(head)) {
    out.push_back(head);
  } else if (colon != head.npos && names_program(head.substr(colon + 2))) {
    out.push_back(head.substr(colon + 2));
  }
  const auto question = next.find("? ", note);
  if (question != next.npos) out.push_back(next.substr(question + 2, next.size() - question - 3));
  return out;
}

std::vector<std::string> proposed_lines(const std::string& answer) {
  constexpr std::string_view kNext = "  next: ";
  std::vector<std::string> out;
  std::istringstream in(answer);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(kNext)) continue;
    for (auto& one : proposed_in(line.substr(kNext.size()))) out.push_back(std::move(one));
  }
  return out;
}

// The words of a command that its answer quotes, because they are what is wrong with it.
std::vector<std::string> blamed(const std::string& command, const std::string& answer) {
  std::vector<std::string> out;
  std::istringstream in(command);
  for (std::string word; in >> std::quoted(word);) {
    word = word.substr(word.find('=') == word.npos ? 0 : word.find('=') + 1);
    for (const char* quote : {"'", "\"", "`"}) {
      if (answer.find(quote + word + quote) != answer.npos) out.push_back(word);
    }
  }
  return out;
}

// A rehearsal that only refuses what a real one refuses before it begins.
Result<RehearseResult> rehearse_nothing(const RehearseRequest& request) {
  auto prepared = prepare_run(request);
  if (!prepared) return fail(prepared.error());
  BenchRequest bench;
  bench.bench = request.bench;
  bench.bench_text = request.bench_text;
  if (auto rig = bench_rig(bench); !rig) return fail(rig.error());
  return RehearseResult();
}

// The folder in which the commands run: the shipped files, an empty database, and a text file.
class Desk {
 public:
  Desk() : home_(fs::current_path()) {
    cli_.bench_rig = &bench_rig;
    cli_.rehearsal = &rehearse_nothing;
    const fs::path data = cli_.dir.file("data");
    fs::create_directories(data);
    fs::create_directory_symlink(home_ / "protocols/library", data / "protocols");
    fs::create_directory_symlink(home_ / "model/library", data / "specimens");
    fs::create_directory_symlink(home_ / "daemon/rig/benches", data / "benches");
    cli_.variables["LCRIG_DATA"] = "data";
    fs::current_path(cli_.dir.file("."));
    EXPECT_TRUE(open_read_write("empty.db"));
    std::ofstream("notes.txt") << "no database\n";
  }
  ~Desk() { fs::current_path(home_); }
  Desk(const Desk&) = delete;
  Desk& operator=(const Desk&) = delete;

  void write(const std::string& name, const std::string& text) { std::ofstream(name) << text; }

  void write_bytes(const std::string& line) {
    std::istringstream in(line);
    std::string name, text;
    in >> name;
    for (int byte = 0; in >> std::hex >> byte;) text += static_cast<char>(byte);
    write(name, text);
  }

  void edit(const std::string& protocol, const std::string& old, const std::string& by) {
    std::string text = text_of("data/protocols/" + protocol + ".json");
    const auto at = text.find(old);
    ASSERT_NE(at, text.npos) << protocol << " has no " << old;
    write("my.json", text.replace(at, old.size(), by));
  }

  std::string answer(const std::string& command) {
    std::istringstream in(command);
    std::vector<std::string> words;
    for (std::string word; in >> std::quoted(word);) words.push_back(word);
    const std::string program = words.front();
    words.erase(words.begin());
    if (program == "lcrigd") return check_config(words.back());
    return answer_of(words);
  }

  std::string answer_of(const std::vector<std::string>& words) {
    code_ = cli_.run(words);
    std::string said = replaced(cli_.out.str() + cli_.err.str(), cli_.dir.file(""), "~/");
    // Messages name the pages where lcrig is installed.
    said = replaced(std::move(said), fs::path(doc_page("cli-json")).parent_path() / "", "docs/");
    return "exit " + std::to_string(code_) + "\n" + said;
  }

  // A person who types the proposed command gets further: a shell can read it, its form is right,
  // and the same message does not come again.
  void try_proposals(const std::string& command, const std::string& answer) {
    const auto mistake = first_line(answer);
    for (const auto& line : proposed_lines(answer)) {
      SCOPED_TRACE(line);
      for (const auto& word : blamed(command, mistake)) {
        EXPECT_EQ((" " + line + " ").find(" " + word + " "), std::string::npos) << word;
      }
      if (!line.starts_with("lcrig ")) {
        EXPECT_THAT(line,
                    testing::MatchesRegex("systemctl (status|stop) lcrigd|sudo adduser .USER lcrig|"
                                          "mkdir -p [^ ]+|df -h"));
        continue;
      }
      ++tried;
      const auto said = answer_of(support::read_by_shell(cli_.dir.file("line.sh"), line));
      EXPECT_NE(code_, cli::kUsage) << said;
      if (code_ != cli::kOk) {
        EXPECT_NE(first_line(said), mistake);
      }
    }
  }

  int tried = 0;

 private:
  static std::string check_config(const std::string& file) {
    const auto config = load_config(file);
    return config ? "in order\n" : config.error().what + "\n" + config.error().detail;
  }

  // First line of the answer, without the exit status.
  static std::string first_line(const std::string& answer) {
    std::istringstream in(answer);
    std::string line;
    std::getline(in, line);
    std::getline(in, line);
    return line;
  }

  fs::path home_;
  support::Cli cli_;
  int code_ = 0;
};

// All commands of a theme with their answers.
std::string transcript(const fs::path& theme, int& commands, int& proposals) {
  std::ifstream in(theme);
  Desk desk;
  std::string out;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("file ")) {
      std::string text;
      for (std::string inner; std::getline(in, inner) && inner != "end";) text += inner + "\n";
      desk.write(line.substr(5), text);
    } else if (line.starts_with("bytes ")) {
      desk.write_bytes(line.substr(6));
    } else if (line.starts_with("edit ")) {
      const auto colon = line.find(": "), arrow = line.find(" => ");
      desk.edit(line.substr(5, colon - 5), line.substr(colon + 2, arrow - colon - 2),
                line.substr(arrow + 4));
      out += line + "\n";
    } else if (line.starts_with("$ ")) {
      const auto answer = desk.answer(line.substr(2));
      out += line + "\n" + answer + "\n";
      SCOPED_TRACE(line);
      desk.try_proposals(line.substr(2), answer);
      ++commands;
    }
  }
  proposals += desk.tried;
  return out;
}

// "-p speed_mm_s=0.27, -p force_N=1.4)": the values by name.
std::map<std::string, std::string> proposed_parameters(const std::string& answer) {
  std::map<std::string, std::string> out;
  for (auto at = answer.find("-p "); at != answer.npos; at = answer.find("-p ", at + 1)) {
    const auto equals = answer.find('=', at);
    const auto end = answer.find_first_of(",)\n", at);
    if (equals < end)
      out[answer.substr(at + 3, equals - at - 3)] = answer.substr(equals + 1, end - equals - 1);
  }
  out.erase("NAME");
  return out;
}

TEST(Mistakes, AParameterThatAPlanProposesIsAccepted) {
  Desk desk;
  for (const auto& [protocol, name, value] : {std::tuple("dynamic-cycles", "speed_mm_s", "1"),
                                              std::tuple("dynamic-cycles", "force_N", "2"),
                                              std::tuple("dynamic-cycles", "force_N", "1.5"),
                                              std::tuple("static-frame", "force_limit_N", "0.1"),
                                              std::tuple("static-frame", "to_kPa", "300")}) {
    std::map<std::string, std::string> values{{name, value}};
    const auto plan = [&] {
      std::vector<std::string> words{"protocol", "plan", protocol};
      for (const auto& [key, v] : values) words.insert(words.end(), {"-p", key + "=" + v});
      return desk.answer_of(words);
    };
    const std::string refused = plan();
    SCOPED_TRACE(refused);
    EXPECT_TRUE(refused.starts_with("exit 6"));
    const auto proposed = proposed_parameters(refused);
    EXPECT_FALSE(proposed.empty());
    for (const auto& [key, v] : proposed) values[key] = v;
    EXPECT_THAT(plan(), testing::StartsWith("exit 0"));
  }
}

TEST(Mistakes, AreAnsweredAsTheCorpusSays) {
  const fs::path folder = fs::absolute("tests/corpus/mistakes");
  int commands = 0, proposals = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".txt") continue;
    auto expected = entry.path();
    expected.replace_extension(".expected");
    const std::string said = transcript(entry.path(), commands, proposals);
    if (std::getenv("LCRIG_WRITE_EXPECTED") != nullptr) std::ofstream(expected) << said;
    EXPECT_EQ(said, text_of(expected)) << entry.path();
  }
  EXPECT_GE(commands, 100);
  EXPECT_GE(proposals, 60);
}

}  // namespace
}  // namespace lcrig
