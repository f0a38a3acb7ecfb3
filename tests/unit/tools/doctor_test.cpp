// SPDX-License-Identifier: Apache-2.0
// Findings of `lcrig doctor` on a computer that a test makes up.
#include "tools/lcrig/doctor.hpp"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "base/whole_file.hpp"
#include "base/wire_log_name.hpp"
#include "storage/database.hpp"
#include "storage/queue.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/unit/tools/served.hpp"
#include "tools/lcrig/doctor_bundle.hpp"
#include "tools/lcrig/tarball.hpp"
#include "tools/lcrig/without_values.hpp"

namespace lcrig::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class Doctor : public ::testing::Test {
 protected:
  Doctor() {
    machine.root = dir.path();
    machine.output = [this](const std::vector<std::string>&) { return printed; };
    machine.clock_is_synchronised = [this] { return synchronised; };
  }
  void file(const std::string& name, const std::string& text) const {
    fs::create_directories(fs::path(dir.file(name)).parent_path());
    std::ofstream(dir.file(name)) << text;
  }
  // Adds a terminal of this USB device, and the process that has it open.
  void plug_in(const std::string& vendor, const std::string& product) const {
    file("dev/ttyUSB0", "");
    ::chmod(dir.file("dev/ttyUSB0").c_str(), 0666);
    file("sys/devices/usb1/idVendor", vendor + "\n");
    file("sys/devices/usb1/idProduct", product + "\n");
    fs::create_directories(dir.file("sys/devices/usb1/if0/ttyUSB0"));
    fs::create_directories(dir.file("sys/class/tty/ttyUSB0"));
    fs::create_directory_symlink(dir.file("sys/devices/usb1/if0/ttyUSB0"),
                                 dir.file("sys/class/tty/ttyUSB0/device"));
  }
  void open_it(const std::string& program) const {
    file("proc/123/comm", program + "\n");
    fs::create_directories(dir.file("proc/123/fd"));
    fs::create_symlink(fs::canonical(dir.file("dev/ttyUSB0")), dir.file("proc/123/fd/3"));
  }
  Findings ports_of(const std::string& meter) const {
    RigConfig config;
    config.meter_port = meter;
    Findings out;
    look_at_ports(machine, config, out);
    return out;
  }
  Findings service() const {
    Findings out;
    look_at_service(machine, out);
    return out;
  }

  TempDir dir;
  Machine machine;
  std::optional<std::string> printed;
  std::optional<bool> synchronised;
};

TEST_F(Doctor, SaysWhetherTheClockIsSynchronised) {
  EXPECT_EQ(look_at_clock(machine).health, Health::warn);
  synchronised = true;
  EXPECT_EQ(look_at_clock(machine).health, Health::ok);
  synchronised = false;
  EXPECT_EQ(look_at_clock(machine).health, Health::warn);
  EXPECT_THAT(look_at_clock(machine).mend, HasSubstr("timedatectl"));
}

TEST_F(Doctor, ReadsTheStealTime) {
  EXPECT_EQ(look_at_steal(machine).health, Health::warn) << "not known is not in order";
  file("proc/stat", "cpu  100 0 100 800 0 0 0 0 0 0\ncpu0 1 2 3\n");
  EXPECT_EQ(look_at_steal(machine).health, Health::ok);
  file("proc/stat", "cpu  100 0 100 780 0 0 0 20 0 0\n");
  EXPECT_EQ(look_at_steal(machine).health, Health::warn);
  EXPECT_THAT(look_at_steal(machine).what, HasSubstr("2.00 %"));
  file("proc/stat", "cpu  100 0 100 700 0 0 0 100 0 0\n");
  EXPECT_EQ(look_at_steal(machine).health, Health::bad);
}

TEST_F(Doctor, LooksAtTheService) {
  EXPECT_EQ(worst_of(service()), Health::ok) << "no systemd";
  fs::create_directories(dir.file("run/systemd/system"));
  EXPECT_EQ(worst_of(service()), Health::warn) << "systemctl failed";
  const std::string sandbox = "ProtectSystem=strict\nPrivateNetwork=yes\nNoNewPrivileges=yes\n";
  const std::string active = "LoadState=loaded\nActiveState=active\nSubState=running\n";
  printed = active + "NRestarts=0\n" + sandbox;
  EXPECT_EQ(worst_of(service()), Health::ok);
  printed = active + "NRestarts=3\n" + sandbox;
  EXPECT_EQ(worst_of(service()), Health::warn);
  printed = active + "NRestarts=0\nProtectSystem=no\n";
  EXPECT_EQ(worst_of(service()), Health::warn);
  printed = "LoadState=loaded\nActiveState=failed\nResult=exit-code\nNRestarts=5\n" + sandbox;
  EXPECT_EQ(worst_of(service()), Health::bad);
  EXPECT_THAT(service().front().what, HasSubstr("exit-code"));
  EXPECT_THAT(service().front().mend, HasSubstr("journalctl -u lcrigd"));
}

TEST_F(Doctor, SaysWhetherTheDaemonIsLockedInMemory) {
  file("proc/77/status", "Name:\tlcrigd\nVmLck:\t   20480 kB\n");
  file("proc/78/status", "Name:\tlcrigd\nVmLck:\t       0 kB\n");
  Findings findings;
  look_at_memory(machine, std::nullopt, findings);
  EXPECT_TRUE(findings.empty());
  look_at_memory(machine, 77, findings);
  look_at_memory(machine, 78, findings);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].health, Health::ok);
  EXPECT_EQ(findings[1].health, Health::warn);
}

TEST_F(Doctor, FindsAPortByItsIdsAndWhoHasItOpen) {
  EXPECT_EQ(worst_of(ports_of("serial:2184:005f")), Health::bad);
  EXPECT_EQ(worst_of(ports_of("serial:/dev/ttyUSB0")), Health::bad);
  plug_in("2184", "005f");
  EXPECT_THAT(ports_of("serial:2184:005F").back().what, HasSubstr("/dev/ttyUSB0: nobody"));
  EXPECT_EQ(worst_of(ports_of("serial:0403:6001")), Health::bad) << "another device";
  EXPECT_EQ(worst_of(ports_of("serial:2184:005f:OTHER")), Health::bad) << "another of its kind";
  EXPECT_THAT(ports_of("serial:2184").back().what, HasSubstr("expected serial:/dev/NAME"));
  open_it("minicom");
  EXPECT_EQ(ports_of("serial:2184:005f").back().health, Health::bad);
  EXPECT_THAT(ports_of("/dev/ttyUSB0").back().what, HasSubstr("minicom (process 123)"));
  file("proc/123/comm", "lcrigd\n");
  EXPECT_EQ(ports_of("serial:2184:005f").back().health, Health::ok);
  EXPECT_EQ(worst_of(ports_of("tcp:gateway:4710")), Health::ok);
  EXPECT_TRUE(ports_of("").empty());
}

TEST_F(Doctor, NamesTheRightsThatAPortLacks) {
  file("dev/ttyUSB0", "");
  ::chmod(dir.file("dev/ttyUSB0").c_str(), 0600);
  const auto found = ports_of("/dev/ttyUSB0");
  EXPECT_EQ(found.front().health, Health::warn);
  EXPECT_THAT(found.front().what, HasSubstr("mode 600"));
}

TEST_F(Doctor, NamesTheKernelModulesThatAreMissing) {
  RigConfig config;
  Findings findings;
  config.meter_port = "tcp:gateway:4710";
  look_at_modules(machine, config, findings);
  EXPECT_TRUE(findings.empty()) << "nothing serial is there";
  config.meter_port = "serial:2184:005f";
  for (const char* module : {"usbserial", "ftdi_sio", "cp210x", "ch341", "pl2303", "cdc_acm"}) {
    findings.clear();
    look_at_modules(machine, config, findings);
    EXPECT_THAT(findings.front().what, HasSubstr(module));
    fs::create_directories(dir.file("sys/module/" + std::string(module)));
  }
  findings.clear();
  look_at_modules(machine, config, findings);
  EXPECT_EQ(worst_of(findings), Health::ok);
}

TEST_F(Doctor, ReadsTheConfig) {
  Findings findings;
  EXPECT_FALSE(look_at_config(dir.file("none.json"), findings));
  EXPECT_EQ(worst_of(findings), Health::warn);
  file("empty.json", "");
  findings.clear();
  EXPECT_FALSE(look_at_config(dir.file("empty.json/rig.json"), findings));
  EXPECT_THAT(findings.front().what, HasSubstr("Not a directory")) << "and no other errno";
  EXPECT_FALSE(look_at_config(dir.file("empty.json"), findings));
  EXPECT_EQ(worst_of(findings), Health::bad);
  file("rig.json", R"({"format": "lcrigd-config/1", "meter": {"port": "serial:2184:005f"},
    "frame": {"driver": "dead_weight"}, "wire_log_directory": "/var/log/lcrig"})");
  findings.clear();
  const auto config = look_at_config(dir.file("rig.json"), findings);
  ASSERT_TRUE(config) << findings.front().what;
  EXPECT_EQ(config->meter_port, "serial:2184:005f");
  EXPECT_EQ(config->frame_port, "");
  EXPECT_EQ(config->wire_log_directory, "/var/log/lcrig");
}

TEST_F(Doctor, ChecksPagesChainAndDisk) {
  const auto path = dir.file("rig.db");
  {
    const auto db = open_read_write(path).value();
    RunRow row;
    row.started_unix_ns = 1'000'000'000;
    ASSERT_TRUE(insert_run(db, row));
    ASSERT_TRUE(insert_run_end(db, 1, RunEnd()));
    Findings findings;
    look_at_database(db, findings);
    ASSERT_EQ(findings.size(), 2U);
    EXPECT_EQ(worst_of(findings), Health::ok);
    const std::int64_t ten_days_later = row.started_unix_ns + 864'000'000'000'000;
    EXPECT_THAT(
        look_at_disk(db, ten_days_later).what,
        AllOf(HasSubstr(" kB a day: room for more than ten years"), Not(HasSubstr("grew by 0 "))));
    ASSERT_TRUE(
        db.execute("DROP TRIGGER run_end_no_update; UPDATE run_end SET reason = 'fine';"
                   "PRAGMA wal_checkpoint(TRUNCATE)"));
    findings.clear();
    look_at_database(db, findings);
    EXPECT_EQ(findings.back().health, Health::bad);
    EXPECT_EQ(findings.back().about, "run 1");
  }
  {
    std::fstream raw(path, std::ios::in | std::ios::out | std::ios::binary);
    raw.seekp(4096);
    raw << std::string(4096, '\x55');
  }
  const auto damaged = open_read_only(path);
  ASSERT_TRUE(damaged) << damaged.error().what;
  Findings findings;
  look_at_database(*damaged, findings);
  EXPECT_EQ(findings.front().health, Health::bad);
}

TEST_F(Doctor, FindsADatabaseOfTwoNamesAsLcrigdDoes) {
  const auto path = dir.file("rig.db");
  const auto db = open_read_write(path).value();
  Findings findings;
  look_at_database(db, findings);
  EXPECT_EQ(worst_of(findings), Health::ok);
  fs::create_hard_link(path, dir.file("other.db"));
  findings.clear();
  look_at_database(db, findings);
  EXPECT_EQ(worst_of(findings), Health::bad);
  EXPECT_THAT(findings.back().what, HasSubstr("2 names (hard links)"));
  EXPECT_THAT(findings.back().mend, HasSubstr("remove the other names"));
}

TEST_F(Doctor, NoticesThatTheDaemonHasAnotherFileOpen) {
  const std::string path = dir.file("rig.db");
  ASSERT_TRUE(open_read_write(path));
  const auto words = [&] {
    const auto found = look_whether_replaced(machine, path);
    return found ? found->what : std::string();
  };
  EXPECT_THAT(words(), HasSubstr("another file of this name open")) << "its lock went with it";
  const auto lock = WriterLock::acquire(path).value();
  EXPECT_EQ(words(), "") << "what it has open cannot be seen";
  const auto open = fs::path(dir.file("proc")) / std::to_string(::getpid()) / "fd";
  fs::create_directories(open);
  fs::create_symlink("socket:[7]", open / "3");
  fs::create_symlink(path, open / "4");
  EXPECT_EQ(words(), "");
  fs::rename(path, path + ".old");
  fs::copy_file(path + ".old", path);
  fs::remove(open / "4");
  fs::create_symlink(path + ".old", open / "4");
  EXPECT_THAT(words(), HasSubstr("begins no run"));
}

TEST_F(Doctor, ComparesTheDiskWithThePlansOfTheQueue) {
  const auto db = open_read_write(dir.file("rig.db")).value();
  EXPECT_EQ(look_at_plans(db).health, Health::ok);
  EXPECT_THAT(look_at_plans(db).what, HasSubstr("needs 0.0 MB, 67.1 MB have to stay free"));
  QueuedRun waits;
  waits.protocol_name = "creep";
  waits.protocol_text = "protocol creep";
  waits.specimen_name = "paper-1";
  waits.specimen_text = "{}";
  waits.plan_json = R"({"bytes":2500000})";
  QueueActor who;
  who.user = "lab";
  ASSERT_TRUE(add_to_queue(db, std::vector{waits}, QueuePlace(), who));
  EXPECT_THAT(look_at_plans(db).what, HasSubstr("needs 2.5 MB"));
  waits.plan_json = R"({"bytes":4000000000000000000})";
  ASSERT_TRUE(add_to_queue(db, std::vector{waits}, QueuePlace(), who));
  EXPECT_EQ(look_at_plans(db).health, Health::bad);
  EXPECT_THAT(look_at_plans(db).mend, HasSubstr("queue remove"));
}

TEST_F(Doctor, TellsTheSettingsOfTheLastRunWithInstruments) {
  const auto db = open_read_write(dir.file("rig.db")).value();
  Findings findings;
  RunRow row;
  row.simulated = true;
  ASSERT_TRUE(insert_run(db, row));
  look_at_meter_settings(db, findings);
  EXPECT_TRUE(findings.empty()) << "nothing was read back from a meter";
  row.simulated = false;
  row.uuid.clear();
  row.lcr_settings_json = R"({"function":"CPD","frequency_Hz":1000.0})";
  ASSERT_TRUE(insert_run(db, row));
  look_at_meter_settings(db, findings);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(worst_of(findings), Health::ok);
  EXPECT_EQ(findings[0].what, "read back in run 2: frequency_Hz 1000.0, function CPD");
  row.lcr_settings_json = "{}";
  ASSERT_TRUE(insert_run(db, row));
  findings.clear();
  look_at_meter_settings(db, findings);
  EXPECT_EQ(worst_of(findings), Health::warn);
}

// A database with a run at day 100, and what doctor says about the corrections.
class DoctorOnCorrections : public ::testing::Test {
 protected:
  void record(std::optional<bool> open, std::optional<bool> short_circuit, bool simulated = false) {
    RunRow row;
    row.simulated = simulated;
    row.started_unix_ns = 100 * kDay_ns;
    row.corrections.emplace();
    row.corrections->meter = "LCR-6100 A";
    row.corrections->open.on = open;
    row.corrections->short_circuit.on = short_circuit;
    ASSERT_TRUE(insert_run(db, row));
  }
  void store(CorrectionKind kind, std::int64_t day, const std::string& meter = "LCR-6100 A") {
    StoredCorrection made;
    made.kind = kind;
    made.meter = meter;
    made.operator_name = "Ada";
    made.made_unix_ns = day * kDay_ns;
    ASSERT_TRUE(add_correction(db, made));
  }
  Findings found(std::int64_t today,
                 const std::optional<MeterCorrections>& asked = std::nullopt) const {
    Findings out;
    look_at_corrections(db, asked, today * kDay_ns, out);
    return out;
  }
  const TempDir dir;
  Database db = open_read_write(dir.file("rig.db")).value();
};

TEST_F(DoctorOnCorrections, FreshOnesThatAreOnAreInOrder) {
  EXPECT_TRUE(found(1).empty()) << "no meter was ever seen";
  record(true, true, true);
  EXPECT_TRUE(found(1).empty()) << "of a bench";
  store(CorrectionKind::open, 90);
  store(CorrectionKind::short_circuit, 90);
  record(true, true);
  const auto now = found(110);
  ASSERT_EQ(now.size(), 2U);
  EXPECT_EQ(worst_of(now), Health::ok);
  EXPECT_EQ(now[0].what,
            "open: on, made 1970-04-01 00:00 UTC by Ada (20 days ago); LCR-6100 A, as run 2 found "
            "it");
  EXPECT_EQ(now[0].mend, "");
  EXPECT_THAT(now[1].what, HasSubstr("short: on"));
}

TEST_F(DoctorOnCorrections, OldOnesAndThoseOfAnotherMeterAreWarnedOf) {
  store(CorrectionKind::open, 90);
  store(CorrectionKind::short_circuit, 99, "LCR-6100 B");
  record(true, true);
  EXPECT_EQ(found(120)[0].health, Health::ok);
  const auto later = found(121);
  EXPECT_EQ(later[0].health, Health::warn);
  EXPECT_THAT(later[0].what, HasSubstr("31 days ago); LCR-6100 A"));
  EXPECT_THAT(later[0].what, HasSubstr("older than 30 days"));
  EXPECT_EQ(later[0].mend, "lcrig lcr correct open");
  EXPECT_EQ(later[1].health, Health::warn);
  EXPECT_THAT(later[1].what, HasSubstr("short: on, not made through lcrig"));
  EXPECT_EQ(later[1].mend, "lcrig lcr correct short");
}

TEST_F(DoctorOnCorrections, OneThatIsOffIsWarnedOfUntilItIsMadeAnewOrTheMeterSaysOtherwise) {
  store(CorrectionKind::open, 90);
  store(CorrectionKind::short_circuit, 90);
  record(false, std::nullopt);
  EXPECT_EQ(found(101)[0].health, Health::warn);
  EXPECT_THAT(found(101)[0].what, HasSubstr("open: off"));
  EXPECT_EQ(found(101)[1].health, Health::ok) << "a meter that cannot say";
  MeterCorrections asked;
  asked.meter = "LCR-6100 A";
  asked.open.on = true;
  asked.open.made_unix_ns = 90 * kDay_ns;
  asked.short_circuit.on = false;
  EXPECT_EQ(found(101, asked)[0].health, Health::ok);
  EXPECT_THAT(found(101, asked)[0].what, HasSubstr("LCR-6100 A, asked now"));
  EXPECT_EQ(found(101, asked)[1].health, Health::warn);
  asked.simulated = true;
  EXPECT_EQ(found(101, asked)[0].health, Health::warn) << "a bench is no news of the meter";
  store(CorrectionKind::open, 101);
  EXPECT_EQ(found(102)[0].health, Health::ok) << "read back as on after the run";
}

// The clock was ahead when the correction was made, and when a run began.
TEST_F(DoctorOnCorrections, ADateInTheFutureIsWarnedOfAndHidesNothing) {
  store(CorrectionKind::open, 400);
  store(CorrectionKind::short_circuit, 400);
  record(true, false);
  const auto now = found(101);
  EXPECT_EQ(now[0].health, Health::warn);
  EXPECT_THAT(now[0].what, AllOf(HasSubstr("open: on"), HasSubstr("(the date is in the future)"),
                                 HasSubstr("look at the clock of this computer")));
  EXPECT_EQ(now[0].mend, "lcrig lcr correct open");
  EXPECT_THAT(now[1].what, HasSubstr("short: off")) << "the run is younger, as its number says";
  EXPECT_THAT(found(401)[1].what, HasSubstr("short: off"));
  store(CorrectionKind::short_circuit, 99);
  EXPECT_THAT(found(101)[1].what, HasSubstr("short: on")) << "it is younger than the run";
  EXPECT_EQ(found(101)[1].health, Health::ok);
}

TEST_F(DoctorOnCorrections, OfAnOlderLcrigNothingIsKnown) {
  ASSERT_TRUE(insert_run(db, RunRow()));
  const auto now = found(1);
  EXPECT_EQ(worst_of(now), Health::warn);
  EXPECT_EQ(now.at(0).what, "open: not known; run 1 is of an older lcrig");
  store(CorrectionKind::open, 1, "LCR-6100 B");
  EXPECT_EQ(found(1).at(0).health, Health::ok);
  EXPECT_THAT(found(1).at(1).what, HasSubstr("short: never made through lcrig; LCR-6100 B"));
}

class DoctorCommandLine : public ::testing::Test {
 protected:
  void SetUp() override {
    cli.variables["LCRIG_DB"] = path;
    ASSERT_TRUE(open_read_write(path));
  }
  support::Cli cli;
  std::string path = cli.dir.file("rig.db"), bundle = cli.dir.file("bundle.tar.gz");
};

TEST_F(DoctorCommandLine, EndsWithTheWorstThatItFound) {
  const int code = cli.run({"doctor", "--json"});
  const auto all = json::parse(cli.out.str());
  const std::map<std::string, int> codes{{"ok", 0}, {"warn", 1}, {"bad", 2}};
  EXPECT_EQ(code, codes.at(all["health"].get<std::string>()));
  EXPECT_GE(code, 1) << "no daemon answers";
  std::string about;
  for (const auto& finding : all["findings"]) about += finding["about"].get<std::string>() + " ";
  for (const char* one : {"daemon", "service", "group", "database", "disk", "clock", "lateness"}) {
    EXPECT_THAT(about, HasSubstr(one));
  }
}

using DoctorOfADaemon = support::Served;

TEST_F(DoctorOfADaemon, ComparesItsDatabaseWithTheFile) {
  const std::string file = cli.dir.file("rig.db");
  const auto open = open_read_write(file);
  ASSERT_TRUE(open);
  on_server([&] { handler.state.database = file; });
  EXPECT_EQ(cli.run({"doctor"}), kUsage) << "nobody has the lock of that file";
  EXPECT_THAT(cli.out.str(), HasSubstr("lcrigd has another file of this name open"));
  const auto lock = WriterLock::acquire(file).value();
  cli.run({"doctor"});
  EXPECT_THAT(cli.out.str(), Not(HasSubstr("another file")));
}

// Unpacks the bundle and returns the folder.
std::string unpacked(const std::string& bundle) {
  const std::string folder = bundle + ".d";
  fs::create_directories(folder);
  const auto tar = real_machine().output({"tar", "-xzf", bundle, "-C", folder});
  EXPECT_TRUE(tar) << bundle;
  return folder + "/doctor-bundle";
}

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> out;
  for (const auto& one : fs::directory_iterator(folder)) out.push_back(one.path().filename());
  return out;
}

TEST_F(DoctorCommandLine, MakesABundleWithoutDataUnlessAsked) {
  EXPECT_LE(cli.run({"doctor", "--bundle", bundle}), 2);
  ASSERT_TRUE(fs::is_regular_file(bundle)) << cli.err.str();
  EXPECT_EQ(fs::status(bundle).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  const auto inside = unpacked(bundle);
  EXPECT_TRUE(fs::exists(inside + "/versions.txt"));
  EXPECT_EQ(json::parse(std::ifstream(inside + "/doctor.json"))["findings"].empty(), false);
  EXPECT_FALSE(fs::exists(inside + "/lcrig.db"));
  EXPECT_EQ(cli.run({"doctor", "--bundle", bundle}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("not there yet"));
  EXPECT_LE(cli.run({"doctor", "--bundle", bundle + "-2", "--with-data"}), 2);
  EXPECT_TRUE(fs::exists(unpacked(bundle + "-2") + "/lcrig.db"));
  EXPECT_EQ(cli.run({"doctor", "--with-data"}), kUsage);
}

// Only the logs of looks contain no measured value.
TEST_F(DoctorCommandLine, PutsWireLogsOfRunsIntoABundleOnlyWhenAsked) {
  BundleParts parts;
  parts.wire_log_directory = cli.dir.file("wires");
  fs::create_directories(parts.wire_log_directory);
  const auto of_looks = wire_log_name("lcr", WireLogOf::looks, 5);
  const auto of_a_run = wire_log_name("lcr", WireLogOf::run, 6);
  for (const auto& name : {of_looks, of_a_run}) {
    std::ofstream(parts.wire_log_directory + "/" + name) << "wire-log/1\n";
  }
  Machine machine = real_machine();
  machine.output = [](const std::vector<std::string>&) { return std::optional<std::string>(); };
  std::ostringstream out, err;
  Console console(out, err);
  for (const bool with_data : {false, true}) {
    parts.with_data = with_data;
    const auto packed = fmt::format("{}-{}", bundle, with_data);
    ASSERT_TRUE(write_bundle(console, machine, packed, parts));
    const auto names = names_in(unpacked(packed));
    EXPECT_THAT(names, ::testing::Contains(of_looks));
    EXPECT_EQ(std::ranges::count(names, of_a_run), with_data ? 1 : 0);
  }
}

TEST_F(DoctorCommandLine, LeavesNothingBehindWhenABundleFails) {
  const std::string folder = cli.dir.file("packed");
  fs::create_directories(folder);
  Machine machine = real_machine();
  machine.output = [&](const std::vector<std::string>&) {
    std::ofstream(folder + "/b.tar.gz") << "somebody else's";
    return std::optional<std::string>();
  };
  std::ostringstream out, err;
  Console console(out, err);
  const auto failed = write_bundle(console, machine, folder + "/b.tar.gz", BundleParts());
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().what, HasSubstr("b.tar.gz"));
  EXPECT_THAT(names_in(folder), ::testing::ElementsAre("b.tar.gz"));
  EXPECT_FALSE(write_bundle(console, machine, folder + "/none/b.tar.gz", BundleParts()));
  EXPECT_THAT(names_in(folder), ::testing::ElementsAre("b.tar.gz"));
}

// Everything except the database is smaller than the limit.
TEST_F(DoctorCommandLine, LeavesNoBundleBehindWithoutTheDatabaseThatDidNotFit) {
  const std::string folder = cli.dir.file("packed");
  fs::create_directories(folder);
  Machine machine = real_machine();
  machine.output = [](const std::vector<std::string>&) { return std::optional<std::string>(); };
  BundleParts parts;
  parts.database = path;
  parts.with_data = true;
  std::ostringstream out, err;
  Console console(out, err);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit low = before;
  low.rlim_cur = 65536;
  ASSERT_LT(low.rlim_cur, fs::file_size(path));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &low), 0);
  const auto written = write_bundle(console, machine, folder + "/b.tar.gz", parts);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().what, HasSubstr("lcrig.db"));
  EXPECT_TRUE(names_in(folder).empty());
  std::ofstream(path, std::ios::trunc) << "no database";
  EXPECT_TRUE(write_bundle(console, machine, folder + "/b.tar.gz", parts));
  EXPECT_THAT(err.str(), HasSubstr("left out: "));
}

TEST_F(DoctorCommandLine, SaysWhatTarSaid) {
  const auto nowhere = PartFile::create(cli.dir.file("nowhere"));
  ASSERT_TRUE(nowhere);
  const auto failed = pack_folder(cli.dir.path(), "none", nowhere->fd());
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().what, HasSubstr("none"));
}

TEST(WithoutValues, BlanksWhatMayHaveBeenMeasured) {
  EXPECT_EQ(without_numbers("run 3: force 3.0110 N is outside -1e-3..2,000.5 N of ttyUSB0"),
            "run 3: force # N is outside -#..# N of ttyUSB0");
  EXPECT_EQ(without_numbers("run 3.5, entry 12, C=12pF, 4"), "run #, entry 12, C=#pF, #");
  EXPECT_EQ(journal_without_numbers("2026-01-31T10:00:00+0000 rig lcrigd[12]: force 3.01 N\n"
                                    "goes on: 2.5\n"),
            "2026-01-31T10:00:00+0000 rig lcrigd[12]: force # N\ngoes on: #\n");
  const json bare = status_without_values(json::parse(R"({"version": "0.1.0",
    "run": {"run": 4, "force_N": 3.0, "prompt": "at 3.0 N"},
    "last_run": {"run": 3, "reason": "force 3.0110 N"}, "queue": {"why": "run 3: 3.0 N"}})"));
  EXPECT_EQ(bare, json::parse(R"({"version": "0.1.0", "run": {"run": 4, "prompt": "at # N"},
    "last_run": {"run": 3, "reason": "force # N"}, "queue": {"why": "run 3: # N"}})"));
}

}  // namespace
}  // namespace lcrig::cli
