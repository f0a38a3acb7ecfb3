// SPDX-License-Identifier: Apache-2.0
// Exports a run as CSV files (RFC 4180) and a Frictionless Data Package, for `lcrig export`. Rows
// are streamed: memory does not grow with the run. docs/export.md describes every column.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/enum_words.hpp"
#include "storage/chain.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

enum class Layout { readings, frame, levels, events, aligned, answers };
template <>
inline constexpr EnumWords<6> kWordsOf<Layout>{"readings", "frame",   "levels",
                                               "events",   "aligned", "answers"};
// "lcr.csv", "frame.csv", ...
std::string_view file_name(Layout layout);

// Writes one layout to `fd`, which the caller keeps and closes; messages call it `name`.
Result<> export_layout(const Database& db, std::int64_t run, Layout layout, int fd,
                       const std::string& name);

struct ExportOptions {
  std::string directory;  // created if it does not exist
  bool force = false;  // replace files of another run or of another program
  std::string license;  // of the data: a name like CC-BY-4.0, or an address; empty: none is stated
};
// Accepts a licence as Data Packages state it: by name or by address. Errors: invalid_request.
Result<> check_license(std::string_view text);

// Writes every layout and datapackage.json. Each file is written under another name and renamed
// when it is complete. A folder that holds files other than an earlier export of the same run is
// refused, unless `force`.
struct ExportedRun {
  std::vector<std::string> files;  // paths
  ChainReport chain;  // if the chain is broken, the files hold the rows as they are now
};
Result<ExportedRun> export_run(const Database& db, std::int64_t run, const ExportOptions& options);

}  // namespace lcrig
