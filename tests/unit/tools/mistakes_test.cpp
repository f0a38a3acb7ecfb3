// SPDX-License-Identifier: Apache-2.0
// What people type and write that is wrong, and what they are told: tests/corpus/mistakes. Each
// THEME.txt has its answers in THEME.expected, so that a changed message shows up as a diff.
// LCRIG_WRITE_EXPECTED=1 writes the answers anew.
//
// Lines of a THEME.txt:
//   # a comment
//   file NAME            then its lines, until a line `end`
//   bytes NAME 7b 7d     of a file that is no UTF-8
//   edit NAME: OLD => NEW    my.json: the shipped protocol NAME with OLD replaced
//   $ COMMAND            run in a folder that has these files
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <sstream>

#include "daemon/config.hpp"
#include "storage/database.hpp"
#include "tests/support/cli_fixture.hpp"

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

// The folder that the commands run in: the shipped files, an empty database, and a text file.
class Desk {
 public:
  Desk() : home_(fs::current_path()) {
    cli_.bench_rig = &bench_rig;
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
    const int code = cli_.run(words);
    const std::string said = replaced(cli_.out.str() + cli_.err.str(), cli_.dir.file(""), "~/");
    return "exit " + std::to_string(code) + "\n" + said;
  }

 private:
  static std::string check_config(const std::string& file) {
    const auto config = load_config(file);
    return config ? "in order\n" : config.error().what + "\n" + config.error().detail;
  }

  fs::path home_;
  support::Cli cli_;
};

// All commands of a theme with their answers.
std::string transcript(const fs::path& theme, int& commands) {
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
      out += line + "\n" + desk.answer(line.substr(2)) + "\n";
      ++commands;
    }
  }
  return out;
}

TEST(Mistakes, AreAnsweredAsTheCorpusSays) {
  const fs::path folder = fs::absolute("tests/corpus/mistakes");
  int commands = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".txt") continue;
    auto expected = entry.path();
    expected.replace_extension(".expected");
    const std::string said = transcript(entry.path(), commands);
    if (std::getenv("LCRIG_WRITE_EXPECTED") != nullptr) std::ofstream(expected) << said;
    EXPECT_EQ(said, text_of(expected)) << entry.path();
  }
  EXPECT_GE(commands, 40);
}

}  // namespace
}  // namespace lcrig
