// SPDX-License-Identifier: Apache-2.0
// A run as recorded before runs had uuids: schema 7 and older. For tests of migration and chain.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "storage/migrations.hpp"
#include "storage/row_hash.hpp"
#include "storage/sqlite.hpp"

namespace lcrig::support {

constexpr int kSchemaBeforeUuids = 7;

inline Database database_before_uuids(const std::string& path, int schema = kSchemaBeforeUuids) {
  auto db = Database::open(path, Database::Mode::read_write_create).value();
  EXPECT_TRUE(migrate(db, shipped_migrations().first(static_cast<std::size_t>(schema))));
  return db;
}

// Inserts its row and the link over the row, byte by byte. Numbers of runs count up.
inline Sha256 insert_old_run(const Database& db, std::int64_t run,
                             const std::string& specimen = "paper-1") {
  const std::string digits(64, '0');
  RowHash hash;
  hash.start(Sha256{});
  hash.row('S');
  hash.integer(run);
  for (const auto& text : {std::string("press"), std::string("{}"), digits, std::string("{}")}) {
    hash.text(text);
  }
  hash.null();  // specimen_id
  for (const auto& text : {specimen, std::string("{}")}) hash.text(text);
  hash.null();  // probe_diameter_m
  for (const char* text : {"lcr", "frame", "{}", "{}", "{}", "{}", "bench", "{}"}) hash.text(text);
  hash.integer(1);  // simulated
  for (int i = 0; i < 3; ++i) hash.null();  // seed, model_level, model_error_json
  for (const char* text : {"0.1", "Ada", "note"}) hash.text(text);
  hash.integer(5);
  hash.integer(6);
  hash.text("boot");
  const Sha256 link = hash.finish();
  EXPECT_TRUE(db.change(
      "INSERT INTO run (id, protocol_name, protocol_text, protocol_sha256, parameters_json,"
      " specimen_id, specimen_name, specimen_text, lcr_identity, frame_identity,"
      " lcr_settings_json, frame_capabilities_json, frame_limits_json, correction_json,"
      " bench_name, bench_text, simulated, software_version, operator, note, started_unix_ns,"
      " started_mono_ns, boot_id) VALUES (?, 'press', '{}', ?, '{}', NULL, ?, '{}', 'lcr',"
      " 'frame', '{}', '{}', '{}', '{}', 'bench', '{}', 1, '0.1', 'Ada', 'note', 5, 6, 'boot')",
      run, std::string_view(digits), std::string_view(specimen)));
  auto statement = db.prepare("INSERT INTO chain VALUES (?, 1, 0, 0, 0, 0, 0, 0, ?)").value();
  statement.bind(0, run);
  statement.bind_blob(1, link);
  EXPECT_TRUE(statement.run());
  return link;
}

// Inserts its end and the second link, as under a schema without anchors.
inline Sha256 end_old_run(const Database& db, std::int64_t run, const Sha256& first_link) {
  RowHash hash;
  hash.start(first_link);
  hash.row('Z');
  hash.integer(run);
  for (const char* text : {"abort", "smoke"}) hash.text(text);
  hash.null();
  hash.integer(9);
  const Sha256 link = hash.finish();
  EXPECT_TRUE(db.change("INSERT INTO run_end VALUES (?, 'abort', 'smoke', NULL, 9)", run));
  auto statement = db.prepare("INSERT INTO chain VALUES (?, 2, 0, 0, 0, 0, 0, 1, ?)").value();
  statement.bind(0, run);
  statement.bind_blob(1, link);
  EXPECT_TRUE(statement.run());
  return link;
}

}  // namespace lcrig::support
