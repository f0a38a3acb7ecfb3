// SPDX-License-Identifier: Apache-2.0
// Members of the service's group can read its database but not write it, whatever happened to the
// daemon. They create, change and delete nothing in its folder (0750, files 0640).
#include <fmt/format.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr Person kService{61010, 61011};
constexpr Person kMember{61012, 61011};
constexpr Person kStranger{61013, 61013};

class Readers : public Rig {
 protected:
  void SetUp() override {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can act as other users";
    Rig::SetUp();
    fs::permissions(fs::path(file(".")), fs::perms(0755));
    fs::create_directory(file("state"));
    ASSERT_EQ(::chown(file("state").c_str(), kService.user, kService.group), 0);
    fs::permissions(file("state"), fs::perms(0750));
    fs::create_directory(file("out"));
    fs::permissions(file("out"), fs::perms(0777));
    if (as(kMember, {"--version"}).code != 0)
      GTEST_SKIP() << "others may not enter the build folder";
    const auto done = as(kService, {"rehearse", "static-frame", "--specimen", "paper-1", "--seed",
                                    "7", "-p", "levels=4", "-p", "repeats=2", "--db", db_});
    ASSERT_EQ(done.code, 0) << done.err;
    anchor_ = as(kService, {"verify", "1", "--json", "--db", db_}).last_line().value("anchor", "");
  }

  Ended as(const Person& person, std::vector<std::string> words) {
    words.insert(words.begin(), LCRIG_BIN "/lcrig");
    Child child(words, file("reader" + std::to_string(++asked_) + ".log"), {{"HOME", file("out")}},
                Child::Rights::as_we_are, &person);
    Ended ended;
    ended.out = child.out().rest(60s);
    ended.code = child.wait(60s).value_or(-1);
    ended.err = child.log();
    return ended;
  }

  // Starts the daemon as the unit does, on a simulated bench.
  void start_service() {
    const std::string notify = file("service.notify");
    const NotifySocket ready(notify);
    fs::permissions(notify, fs::perms(0777));
    write("service.json", json{{"format", "lcrigd-config/1"},
                               {"database", db_},
                               {"socket", file_of_socket()},
                               {"bench", file("bench.json")}}
                              .dump());
    const std::vector<std::string> command{LCRIG_BIN "/lcrigd", "--config", file("service.json")};
    daemons_.push_back(std::make_unique<Child>(command, file("service.log"),
                                               Child::Variables{{"NOTIFY_SOCKET", notify}},
                                               Child::Rights::as_we_are, &kService));
    ASSERT_TRUE(ready.wait("READY=1", 20s)) << daemons_.back()->log();
    ::unlink(notify.c_str());
  }
  void end_service(int signal) {
    daemons_.back()->signal(signal);
    ASSERT_TRUE(daemons_.back()->wait(20s));
    daemons_.clear();
  }
  // The run moves nothing, so that a busy computer does not end it.
  void begin_long_run() {
    std::ifstream file("protocols/library/follow.json");
    const std::string follow{std::istreambuf_iterator<char>(file), {}};
    Control client(file_of_socket());
    client.call("watch");
    ASSERT_TRUE(start_run(client, follow).contains("result"));
    client.wait_for("status", [](const json& s) { return s.value("lcr_readings", 0) > 3; }, 60s);
  }
  std::string file_of_socket() const { return file("state/control.sock"); }

  // Name, size and time of the last change. A daemon that works changes its files itself.
  std::map<std::string, std::string> folder(bool with_changes) const {
    std::map<std::string, std::string> out;
    for (const auto& entry : fs::directory_iterator(file("state"))) {
      struct stat s{};
      ::stat(entry.path().c_str(), &s);
      out[entry.path().filename()] =
          with_changes ? fmt::format("{} bytes, changed at {}.{:09}, {:o}", s.st_size,
                                     s.st_mtim.tv_sec, s.st_mtim.tv_nsec, s.st_mode)
                       : fmt::format("{:o}", s.st_mode);
    }
    return out;
  }

  std::vector<std::vector<std::string>> reading_commands() const {
    return {{"queue", "list"},
            {"queue", "history", "--json"},
            {"runs"},
            {"runs", "list", "--json"},
            {"runs", "show", "1"},
            {"verify", "1"},
            {"verify", "1", "--anchor", anchor_},
            {"analyze", "1"},
            {"analyze", "1", "--json"},
            {"report", "1", "-o", file("out/report.html")},
            {"export", "1", "-o", file("out/run-1")},
            {"export", "1", "-o", "-", "--layout", "aligned"},
            {"specimen", "list"},
            {"model", "fit", "1", "--level", "linear"},
            {"budget", "static-frame", "--specimen", "paper-1", "--noise-from", "1", "--json"}};
  }

  // Tries every command as a member and as root, who could create files.
  void expect_readable(const std::string& state, bool quiet = true) {
    SCOPED_TRACE(state);
    for (auto words : reading_commands()) {
      words.insert(words.end(), {"--db", db_});
      const auto before = folder(quiet);
      const Ended done = as(kMember, words);
      EXPECT_EQ(done.code, 0) << testing::PrintToString(words) << '\n' << done.err;
      EXPECT_EQ(folder(quiet), before) << testing::PrintToString(words);
      answered_ += done.code == 0 ? 1 : 0;
      ++tried_;
    }
    const auto names = folder(false);
    EXPECT_EQ(lcrig({"analyze", "1", "--db", db_}).code, 0);
    EXPECT_EQ(folder(false), names) << "root created or deleted something";
  }

  std::string db_ = file("state/lcrig.db"), anchor_;
  int asked_ = 0, tried_ = 0, answered_ = 0;
};

TEST_F(Readers, MembersReadWhateverTheDaemonDoes) {
  expect_readable("never started; a rehearsal recorded");
  start_service();
  expect_readable("it runs");
  begin_long_run();
  expect_readable("a run goes on", false);
  EXPECT_THAT(as(kMember, {"runs", "--db", db_}).out, HasSubstr("running"));
  EXPECT_THAT(as(kMember, {"verify", "2", "--db", db_}).out, HasSubstr("intact so far"));

  end_service(SIGKILL);
  EXPECT_GT(fs::file_size(db_ + "-wal"), 0U);
  expect_readable("killed");
  EXPECT_THAT(as(kMember, {"runs", "--db", db_}).out, HasSubstr("cut off"));
  const auto readings = [this] {
    const auto listed = as(kMember, {"runs", "show", "2", "--json", "--db", db_}).last_line();
    return listed.value("lcr_readings", 0);
  };
  const int stored = readings();
  EXPECT_GT(stored, 3);
  fs::remove(db_ + "-shm");
  expect_readable("killed, and the index of the log was removed");
  EXPECT_EQ(readings(), stored) << "what is only in the log is read";

  start_service();
  EXPECT_THAT(daemons_.back()->log(), HasSubstr("closed as interrupted (anchor "));
  end_service(SIGTERM);
  EXPECT_EQ(fs::file_size(db_ + "-wal"), 0U);
  expect_readable("stopped");
  fs::remove(db_ + "-shm");
  expect_readable("stopped, without -shm");
  fs::remove(db_ + "-wal");
  expect_readable("stopped by an older lcrigd, which left neither");
  std::printf("%d of %d commands answered\n", answered_, tried_);
}

TEST_F(Readers, MembersReadAReadOnlyMedium) {
  const std::string medium = file("medium");
  fs::create_directory(medium);
  for (const bool companions : {true, false}) {
    if (!companions) {
      for (const char* name : {"-wal", "-shm", ".lock"}) fs::remove(db_ + name);
    }
    if (::mount(file("state").c_str(), medium.c_str(), nullptr, MS_BIND, nullptr) != 0) {
      GTEST_SKIP() << "needs the right to mount";
    }
    const int frozen =
        ::mount(nullptr, medium.c_str(), nullptr, MS_REMOUNT | MS_BIND | MS_RDONLY, nullptr);
    EXPECT_EQ(frozen, 0);
    const std::string on_disk = std::exchange(db_, medium + "/lcrig.db");
    EXPECT_FALSE(::access(db_.c_str(), W_OK) == 0);
    expect_readable(companions ? "all files" : "the database alone");
    db_ = on_disk;
    ASSERT_EQ(::umount2(medium.c_str(), MNT_DETACH), 0);
  }
}

TEST_F(Readers, OthersAreToldWhoMayRead) {
  const auto refused = as(kStranger, {"runs", "--db", db_});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr(db_), HasSubstr("Permission denied"), HasSubstr("group")));
}

}  // namespace
}  // namespace lcrig::e2e
