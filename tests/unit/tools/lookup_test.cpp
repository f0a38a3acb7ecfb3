// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "base/near_word.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tools/lcrig/library_path.hpp"

namespace lcrig::cli {
namespace {

using ::testing::HasSubstr;

TEST(DidYouMean, FindsTyposSwapsAndBeginnings) {
  const std::vector<std::string> known{"run", "runs", "rehearse", "dynamic-cycles", "plan"};
  EXPECT_EQ(nearest_word("rnu", known), "run");
  EXPECT_EQ(nearest_word("reherse", known), "rehearse");
  EXPECT_EQ(nearest_word("dyn", known), "dynamic-cycles");
  EXPECT_EQ(nearest_word("dynamic_cycles", known), "dynamic-cycles");
  EXPECT_EQ(nearest_word("xyzzy", known), std::nullopt);
  EXPECT_EQ(nearest_word("", known), std::nullopt);
  EXPECT_EQ(nearest_word(std::string(100'000, 'r'), known), std::nullopt);
}

class Lookup : public ::testing::Test {
 protected:
  support::Cli cli;
  LibraryPath library() const { return LibraryPath(cli.env); }
};

TEST_F(Lookup, DataFolderFirstThenSourceTreeThenInstalled) {
  const std::filesystem::path root = cli.dir.file("tree");
  const std::filesystem::path build = cli.dir.file("elsewhere/build");
  cli.env.executable = build / "bin/lcrig";
  const auto write = [](const std::filesystem::path& path, const std::string& text) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  };
  write(build / "share/lcrig/protocols/a.json", "installed");
  EXPECT_EQ(library().get(LibraryKind::protocol, "a")->text, "installed");
  write(root / "protocols/library/a.json", "source");
  EXPECT_EQ(library().get(LibraryKind::protocol, "a")->text, "installed");  // no build tree
  write(build / "CMakeCache.txt",
        "# made by CMake\nCMAKE_HOME_DIRECTORY:INTERNAL=" + root.string() + "\n");
  EXPECT_EQ(library().get(LibraryKind::protocol, "a")->text, "source");
  cli.add_data("protocols/a.json", "data");
  EXPECT_EQ(library().get(LibraryKind::protocol, "a")->text, "data");
  EXPECT_EQ(library().list(LibraryKind::protocol).size(), 1U);
}

TEST_F(Lookup, WithoutAnyProtocolTheListFails) {
  EXPECT_EQ(cli.run({"protocol", "list"}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("no protocol is installed"));
  cli.add_data("protocols/a.json", "{}");
  EXPECT_EQ(cli.run({"protocol", "list"}), kOk);
}

// Runs are found by this name, reports are titled with it, and the queue compares it.
TEST_F(Lookup, ASpecimenOfAFileIsCalledAsItSaysItself) {
  std::ifstream in("model/library/paper-1.json");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::string file = cli.dir.file("stackX.json"), broken = cli.dir.file("broken.json");
  std::ofstream(file) << text;
  std::ofstream(broken) << "{";
  EXPECT_EQ(library().find(LibraryKind::specimen, file).value()->name, "paper-1");
  EXPECT_EQ(library().find(LibraryKind::specimen, broken).value()->name, "broken");
  cli.add_data("specimens/stackY.json", text);
  EXPECT_EQ(library().find(LibraryKind::specimen, "stackY").value()->name, "paper-1");
  cli.add_data("protocols/press.json", "{}");
  cli.run({"rehearse", "press", "--specimen", file});
  EXPECT_EQ(support::FakeRehearsal::last.specimen_name, "paper-1");
}

TEST_F(Lookup, ABuildTreeFindsWhatShipsInItsSources) {
  const std::filesystem::path build = cli.dir.file("build");
  cli.env.executable = build / "bin/lcrig";
  std::filesystem::create_directories(build);
  std::ofstream(build / "CMakeCache.txt")
      << "CMAKE_HOME_DIRECTORY:INTERNAL=" << std::filesystem::current_path().string() << "\n";
  for (const auto kind : {LibraryKind::protocol, LibraryKind::specimen, LibraryKind::bench}) {
    EXPECT_FALSE(library().list(kind).empty()) << static_cast<int>(kind);
  }
}

TEST_F(Lookup, APathIsTakenAsItIs) {
  const auto path = cli.dir.file("mine.json");
  EXPECT_FALSE(library().get(LibraryKind::protocol, path));
  std::ofstream(path) << "text";
  const auto file = library().get(LibraryKind::protocol, path);
  ASSERT_TRUE(file);
  EXPECT_EQ(file->name, "mine");
  EXPECT_EQ(file->text, "text");
}

TEST_F(Lookup, AMissingFileIsNamed) {
  const auto file = library().get(LibraryKind::protocol, cli.dir.file("gone.json"));
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().what, HasSubstr("gone.json"));
}

TEST_F(Lookup, AFileOfAnotherKindInTheFolderIsNotListed) {
  cli.add_data("specimens/s.json", R"({"format":"specimen/1"})");
  cli.add_data("specimens/b.json", R"({"format":"bench/1"})");
  ASSERT_EQ(library().list(LibraryKind::specimen).size(), 1U);
  EXPECT_EQ(library().list(LibraryKind::specimen)[0].name, "s");
  EXPECT_FALSE(library().get(LibraryKind::specimen, "b"));
}

TEST_F(Lookup, NothingInstalledSaysSo) {
  const auto failure = library().unknown(LibraryKind::protocol, "x");
  EXPECT_EQ(failure.code, kProtocol);
  EXPECT_THAT(failure.what, HasSubstr("LCRIG_DATA"));
}

constexpr auto kSpecimen = R"({ "format": "specimen/1", "name": "mine", "disc_diameter_mm": 4.0,
  "faces": "free", "materials": { "PDMS": { "relative_permittivity": 2.75,
    "youngs_modulus_kPa": 200, "poisson_ratio": 0.49, "shear_modulus_kPa": 42 } },
  "capacitors": [ { "layers": [ { "material": "PDMS", "thickness_um": 25 } ] } ] })";

TEST_F(Lookup, AnAddedSpecimenIsFoundListedAndShown) {
  const auto file = cli.dir.file("mine.json");
  const auto db = cli.dir.file("x.db");
  std::ofstream(file) << kSpecimen;
  ASSERT_EQ(cli.run({"specimen", "add", file, "--db", db}), 0) << cli.err.str();
  ASSERT_EQ(cli.run({"specimen", "list", "--db", db}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("mine"));
  EXPECT_THAT(cli.out.str(), HasSubstr("paper-1"));
  ASSERT_EQ(cli.run({"specimen", "show", "mine", "--db", db}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("disc_diameter_mm"));
}

TEST_F(Lookup, AWrongSpecimenIsRefusedAndNothingIsStored) {
  const auto file = cli.dir.file("bad.json");
  std::ofstream(file) << R"({ "format": "specimen/1", "name": 3 })";
  EXPECT_EQ(cli.run({"specimen", "add", file, "--db", cli.dir.file("y.db")}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("bad.json"));
  EXPECT_FALSE(std::filesystem::exists(cli.dir.file("y.db")));
}

TEST_F(Lookup, AnInvalidProtocolIsSix) {
  cli.add_data("protocols/bad.json", R"({"format":"load-protocol/1"})");
  EXPECT_EQ(cli.run({"protocol", "check", "bad"}), kProtocol);
  EXPECT_THAT(cli.err.str(), HasSubstr("docs/protocol-file.md"));
  EXPECT_EQ(cli.run({"protocol", "show", "bad"}), kProtocol);
}

}  // namespace
}  // namespace lcrig::cli
