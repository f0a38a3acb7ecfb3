// SPDX-License-Identifier: Apache-2.0
// Databases that older programs recorded: tests/old_databases. Each is a rehearsal of one protocol
// (its text is in the run) with the specimen paper-1 and the seed 7, written by a program whose
// newest schema was that of the name. The events beside it are what such a program exported.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "storage/database.hpp"
#include "storage/migrations.hpp"
#include "tests/support/cli_fixture.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// What the program printed that recorded the run.
struct OldFile {
  int schema;
  const char* anchor;
  int readings, samples, events;
  double dynamic_range_percent, peak_N;  // of the second loading
  std::optional<int> unproven = {};  // absent: nothing was read back then, so all readings count
};
void PrintTo(const OldFile& file, std::ostream* out) {
  *out << "schema " << file.schema;
}

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

class OldDatabase : public ::testing::TestWithParam<OldFile> {
 protected:
  void SetUp() override {
    fs::copy_file(stored(".sqlite"), path);
    fs::permissions(path, fs::perms::owner_write, fs::perm_options::add);
    cli.variables["LCRIG_DB"] = path;
  }
  static std::string stored(const std::string& suffix) {
    return "tests/old_databases/schema-" + std::to_string(GetParam().schema) + suffix;
  }
  std::int64_t schema() const {
    return open_read_only(path)->integer("PRAGMA user_version").value_or(0);
  }
  json answer(std::vector<std::string> words) {
    words.emplace_back("--json");
    EXPECT_EQ(cli.run(words), 0) << cli.err.str();
    return json::parse(cli.out.str(), nullptr, false);
  }
  void expect_the_run_as_it_was_recorded() {
    const json verified = answer({"verify", "1"});
    EXPECT_EQ(verified["intact"], true) << verified["finding"];
    EXPECT_EQ(verified["anchor"], GetParam().anchor);
    const json shown = answer({"runs", "show", "1"});
    EXPECT_EQ(shown["exit_status"], "success");
    EXPECT_EQ(shown["lcr_readings"], GetParam().readings);
    EXPECT_EQ(shown["unproven_readings"], GetParam().unproven.value_or(0));
    EXPECT_EQ(shown["frame_samples"], GetParam().samples);
    EXPECT_EQ(shown["events"], GetParam().events);
    // Within their standard errors, because a later program may estimate better.
    const json results = answer({"analyze", "1"});
    EXPECT_NEAR(results["C0_pF"].get<double>(), 3.649, 0.019);
    EXPECT_NEAR(results["dynamic_range_percent"].get<double>(), GetParam().dynamic_range_percent,
                0.49);
    ASSERT_EQ(results["cycles"].size(), 2U);
    EXPECT_NEAR(results["cycles"][1]["peak_force_N"].get<double>(), GetParam().peak_N, 1e-3);
    EXPECT_EQ(results["proof_known"], GetParam().unproven.has_value());
    EXPECT_EQ(results["unproven_readings"], GetParam().unproven.value_or(0));
    int told = 0;
    for (const json& note : results["notes"]) {
      told += note.get<std::string>().find("were not read back after the run") != std::string::npos
                  ? 1
                  : 0;
    }
    EXPECT_EQ(told, GetParam().unproven ? 0 : 1) << results["notes"];
    const std::string folder = cli.dir.file("out-of-" + fs::path(path).filename().string());
    answer({"export", "1", "-o", folder});
    EXPECT_EQ(content_of(folder + "/events.csv"), content_of(stored(".events.csv")));
  }

  support::Cli cli;
  std::string path = cli.dir.file("old.db");
};

TEST_P(OldDatabase, IsReadAsItIs) {
  expect_the_run_as_it_was_recorded();
  EXPECT_EQ(schema(), GetParam().schema);
  EXPECT_TRUE(content_of(path) == content_of(stored(".sqlite"))) << "a reader changed the file";
}

TEST_P(OldDatabase, KeepsItsRunWhenItIsBroughtUpToDate) {
  ASSERT_TRUE(open_read_write(path));
  EXPECT_EQ(schema(), shipped_migrations().back().version);
  expect_the_run_as_it_was_recorded();
  const std::string copy = cli.dir.file("copy.db");
  answer({"runs", "copy", "1", "--to", copy});
  path = cli.variables["LCRIG_DB"] = copy;
  expect_the_run_as_it_was_recorded();
}

INSTANTIATE_TEST_SUITE_P(
    All, OldDatabase,
    ::testing::Values(
        OldFile{8, "58:eefaab17eb47ac00afa97e4bd7ffcdbbd61d7d98427f14d2a1a56f84453b5675", 420, 279,
                53, 11.04, 0.8018},
        OldFile{9, "58:da14f727425dc00e7878161b85c346ea6faf7a24370a12d85b6437087028e1bd", 420, 279,
                53, 11.04, 0.8018},
        OldFile{10, "60:0600cace231fe8826e561d9ecd58e39a7dbe68acb16f5b47469eade569a7074d", 435, 288,
                53, 9.19, 0.8016},
        OldFile{12, "61:05a59d3b55751b11a3b3627ba09a726ea95a6f3e4cba439dbf4ce23c542558dd", 442, 293,
                74, 9.20, 0.8016, 1}),
    [](const auto& test) { return "Schema" + std::to_string(test.param.schema); });

}  // namespace
}  // namespace lcrig::cli
