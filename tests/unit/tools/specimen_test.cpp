// SPDX-License-Identifier: Apache-2.0
// `lcrig specimen`: what it echoes, what it questions, and that each name which it takes can be
// read back.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <random>

#include "model/specimen_file.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/support/shell.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Specimens : public ::testing::Test {
 protected:
  std::string file(const json& specimen) {
    const auto path = cli.dir.file("stack.json");
    std::ofstream(path) << specimen.dump();
    return path;
  }
  static json named(const std::string& name) {
    auto text = json::parse(shipped_specimens().front().text, nullptr, true, true);
    text["name"] = name;
    return text;
  }
  static json thick() {
    json out = named("thick");
    out["capacitors"][0]["layers"][0].erase("thickness_um");
    out["capacitors"][0]["layers"][0]["thickness_mm"] = 60;
    return out;
  }
  static json soft() {
    json out = named("soft");
    out["materials"]["PDMS"].erase("youngs_modulus_kPa");
    out["materials"]["PDMS"]["youngs_modulus_Pa"] = 69;
    return out;
  }
  std::string stored() {
    EXPECT_EQ(cli.run({"specimen", "list", "--db", db}), kOk) << cli.err.str();
    return cli.out.str();
  }
  // The command behind the last `next:`, as a shell reads it.
  std::vector<std::string> proposed() {
    const auto said = cli.err.str();
    constexpr std::string_view kMark = "next: ";
    const auto at = said.rfind(kMark);
    if (at == said.npos) return {};
    const auto line = said.substr(at + kMark.size(), said.find('\n', at) - at - kMark.size());
    return support::read_by_shell(cli.dir.file("line.sh"), line.substr(0, line.rfind("   (")));
  }
  support::Cli cli;
  std::string db = cli.dir.file("lab.db");
};

TEST_F(Specimens, AddAndCheckEchoWhatTheFileComesTo) {
  const auto path = file(named("mine"));
  ASSERT_EQ(cli.run({"specimen", "check", path}), kOk) << cli.err.str();
  const auto echo = AllOf(HasSubstr("C0            3.64"), HasSubstr("100 um in 2 layers"),
                          HasSubstr("25 um of it soft"), HasSubstr("N/mm"), HasSubstr("12.57 mm2"));
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("checked specimen mine"), echo));
  EXPECT_THAT(stored(), Not(HasSubstr("mine")));
  ASSERT_EQ(cli.run({"specimen", "add", path, "--db", db}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("stored specimen mine"), echo));
  ASSERT_EQ(cli.run({"specimen", "add", path, "--db", db, "--json"}), kOk);
  const json out = json::parse(cli.out.str());
  EXPECT_EQ(out["name"], "mine");
  EXPECT_NEAR(out["C0_pF"].get<double>(), 3.646, 1e-3);
  EXPECT_NEAR(out["thickness_um"].get<double>(), 100, 1e-9);
  EXPECT_NEAR(out["pressed_area_mm2"].get<double>(), 12.566, 1e-3);
  EXPECT_GT(out["stiffness_N_per_mm"].get<double>(), 0);
}

TEST_F(Specimens, ImplausibleValuesAreNotStoredWithoutAPerson) {
  for (const auto& [specimen, value] :
       {std::pair(thick(), "thickness of 60000 um"), std::pair(soft(), "modulus of 0.069 kPa")}) {
    const auto path = file(specimen);
    EXPECT_EQ(cli.run({"specimen", "add", path, "--db", db}), kFailed);
    EXPECT_THAT(cli.err.str(),
                AllOf(HasSubstr(value), HasSubstr("plausible is"), HasSubstr("--as-stated")));
    EXPECT_THAT(stored(), Not(HasSubstr(specimen["name"].get<std::string>())));
    EXPECT_EQ(cli.run({"specimen", "add", "--as-stated", path, "--db", db}), kOk);
    EXPECT_THAT(stored(), HasSubstr(specimen["name"].get<std::string>()));
  }
}

TEST_F(Specimens, AtATerminalImplausibleValuesAreAskedFor) {
  cli.tty = true;
  const auto path = file(thick());
  cli.typed = "n";
  EXPECT_EQ(cli.run({"specimen", "add", path, "--db", db}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("store it all the same?"));
  cli.typed = std::nullopt;
  EXPECT_EQ(cli.run({"specimen", "add", path, "--db", db}), kFailed);
  EXPECT_THAT(stored(), Not(HasSubstr("thick")));
  cli.typed = "y";
  EXPECT_EQ(cli.run({"specimen", "add", path, "--db", db}), kOk) << cli.err.str();
  EXPECT_THAT(stored(), HasSubstr("thick"));
}

TEST_F(Specimens, ANameWithASlashIsRefusedWithItsPlace) {
  EXPECT_EQ(cli.run({"specimen", "add", file(named("a/b")), "--db", db}), kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("/name"), HasSubstr("a slash")));
  EXPECT_EQ(cli.run({"model", "curve", "--specimen", file(named("-x"))}), kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("/name"), HasSubstr("a dash")));
}

// Names of characters that mean something to a shell, a file system or an option parser.
std::string drawn_name(std::mt19937& random) {
  static const std::vector<std::string> kPieces{
      "a", "B",  "7",  " ",       "-",  "--", "/", "\\", ".",      "..",     ".json",
      "'", "\"", "$x", "`",       "!",  "*",  "?", "[",  "]",      "{",      "}",
      "(", ")",  ";",  "&",       "|",  "<",  ">", "~",  "#",      "%",      "=",
      ",", "@",  ":",  "replay:", "\n", "\t", "ö", "日", "\u202e", "\u00a0", "\xff"};
  std::string out;
  const auto count = 1 + random() % 5;
  for (std::size_t i = 0; i < count; ++i) out += kPieces[random() % kPieces.size()];
  return out;
}

// The commands are those that `specimen add` proposes, and those that show what is stored.
TEST_F(Specimens, EachNameThatIsTakenIsReadBackByEveryCommandThatIsProposed) {
  std::mt19937 random(7);
  std::ifstream library("protocols/library/static-frame.json");
  std::stringstream text;
  text << library.rdbuf();
  cli.add_data("protocols/static-frame.json", text.str());
  support::FakeRehearsal::answer = RehearseResult();
  support::FakeRehearsal::answer->exit_status = ExitStatus::success;
  int taken = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    const std::string name = drawn_name(random);
    SCOPED_TRACE(::testing::PrintToString(name));
    json specimen = named("x");
    std::string written = specimen.dump();
    const auto at = written.find(R"("name":"x")");
    ASSERT_NE(at, std::string::npos);
    const json quoted(name);
    written.replace(at + 7, 3, quoted.dump(-1, ' ', false, json::error_handler_t::ignore));
    const auto path = cli.dir.file("stack.json");
    std::ofstream(path) << written;
    const std::string meant = json::parse(written)["name"];
    if (cli.run({"specimen", "add", path, "--db", db}) != kOk) {
      // A reader of JSON refuses some characters wherever they stand.
      EXPECT_THAT(cli.err.str(), AnyOf(HasSubstr("/name"), HasSubstr("control characters")));
      ++refused;
      continue;
    }
    ++taken;
    const auto next = proposed();
    ASSERT_EQ(cli.run(next), kOk) << ::testing::PrintToString(next) << cli.err.str();
    EXPECT_EQ(support::FakeRehearsal::last.specimen_name, meant);
    ASSERT_EQ(cli.run({"specimen", "show", meant, "--db", db, "--json"}), kOk) << cli.err.str();
    EXPECT_EQ(json::parse(cli.out.str())["name"], meant);
    ASSERT_EQ(cli.run({"specimen", "list", "--db", db}), kOk);
    EXPECT_THAT(cli.out.str(), HasSubstr(meant));
    ASSERT_EQ(cli.run({"model", "curve", "--specimen", meant, "--pressure-kPa", "1", "--db", db}),
              kOk)
        << cli.err.str();
  }
  EXPECT_GT(taken, 80);
  EXPECT_GT(refused, 80);
}

}  // namespace
}  // namespace lcrig::cli
