// SPDX-License-Identifier: Apache-2.0
// A table of runs as a command line asks for it: `queue add --batch` and `rehearse --batch`.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocols/batch/batch.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

struct BatchRequest {
  std::string name, file_name, table;
  BatchOrder order = BatchOrder::given;
  std::int64_t seed = 0;
  BatchTerms terms;  // terms that the file sets for all rows
  std::vector<BatchEntry> rows;
  std::map<std::string, BatchFile> protocols, specimens;  // by the words in the cells
  std::int64_t runs() const;
};

class BatchOptions {
 public:
  void declare(ArgumentList& list);  // all options but --seed
  bool given() const { return !file_.empty(); }
  // Name of another batch option that was given without a file. "": there is none.
  std::string stray() const;
  const std::string& file() const { return file_; }
  // Reads and checks the whole table. Specimens are looked up in the library and in this database.
  // `seed` is that of a random order; with nullopt the file's seed is used, or else one is drawn.
  // Failure: usage, with all mistakes of the table at once.
  Outcome<BatchRequest> read(const Context& context, const std::string& db_path,
                             std::optional<std::uint64_t> seed) const;

 private:
  Outcome<bool> put_name(const BatchTable& table, BatchRequest& out) const;
  Outcome<bool> put_order(const BatchTable& table, std::optional<std::uint64_t> seed,
                          BatchRequest& out) const;

  std::string file_, name_, order_;
};

}  // namespace lcrig::cli
