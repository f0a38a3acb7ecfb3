// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/batch_request.hpp"

#include <limits>
#include <random>

#include "base/doc_page.hpp"
#include "base/number.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "tools/lcrig/library_path.hpp"

namespace lcrig::cli {

namespace {

std::string how_to_correct() {
  return "correct the table; " + doc_page("batch-file") + " describes it";
}

// An error about the file in a cell, as one line.
Error one_line(const Failure& failure) {
  return Error(Errc::invalid_request, failure.what);
}

BatchFile as_batch_file(LibraryFile file) {
  return {std::move(file.name), file.path.string(), std::move(file.text)};
}

// Keeps the files that the cells name, for the request that queues them.
class Shelf {
 public:
  Shelf(const Context& context, std::string db_path, BatchRequest& out)
      : context_(context), library_(context.env), db_path_(std::move(db_path)), out_(out) {
    std::error_code ignored;
    readable_ = !std::filesystem::exists(db_path_, ignored) || open_read_only(db_path_).has_value();
  }

  Result<BatchFile> protocol(const std::string& word) {
    auto file = library_.get(LibraryKind::protocol, word);
    if (!file) return fail(one_line(file.error()));
    return out_.protocols[word] = as_batch_file(std::move(*file));
  }
  Result<BatchFile> specimen(const std::string& word) {
    auto file = library_.find(LibraryKind::specimen, word);
    if (!file) return fail(one_line(file.error()));
    if (*file) {
      auto parsed = accept_specimen((*file)->text, (*file)->path.string());
      if (!parsed) return fail(parsed.error());
      return out_.specimens[word] = as_batch_file(std::move(**file));
    }
    BatchFile named;
    named.name = word;
    if (!readable_) return named;  // the daemon, which owns the database, will look it up
    auto found = find_specimen_text(context_, db_path_, word);
    if (!found) return fail(one_line(found.error()));
    return out_.specimens[word] = as_batch_file(std::move(*found));
  }

 private:
  const Context& context_;
  LibraryPath library_;
  std::string db_path_;
  BatchRequest& out_;
  bool readable_ = false;
};

std::int64_t drawn_seed() {
  return static_cast<std::int64_t>(std::random_device()());
}

}  // namespace

std::int64_t BatchRequest::runs() const {
  std::int64_t out = 0;
  for (const BatchEntry& row : rows) out += row.repeats;
  return out;
}

void BatchOptions::declare(ArgumentList& list) {
  const std::string help = "A table of runs, CSV or JSON (" + doc_page("batch-file") + ")";
  list.option("--batch", file_, kFileWord, help.c_str());
  list.option("--name", name_, "NAME", "Of the batch (default: that of the file)");
  list.one_of("--order", order_, all_words<BatchOrder>(),
              "Of its runs; blocks: a specimen's together, by chance within (default: given)");
}

std::string BatchOptions::stray() const {
  if (given()) return {};
  if (!name_.empty()) return "--name";
  return order_.empty() ? "" : "--order";
}

Outcome<bool> BatchOptions::put_name(const BatchTable& table, BatchRequest& out) const {
  out.name = std::filesystem::path(file_).stem().string();
  if (table.name) out.name = table.name->text;
  if (!name_.empty()) out.name = name_;
  const auto good = check_text("the name of the batch", out.name, kNameMax);
  if (!good) return Failure(kUsage, good.error().what, "give another --name");
  return true;
}

Outcome<bool> BatchOptions::put_order(const BatchTable& table, std::optional<std::uint64_t> given,
                                      BatchRequest& out) const {
  std::optional<std::int64_t> seed;
  for (const std::string& word : {table.order ? table.order->text : std::string(), order_}) {
    out.order = parse_word<BatchOrder>(word).value_or(out.order);
  }
  if (table.seed) seed = number_from<std::int64_t>(table.seed->text);
  if (given && *given > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
    return Failure(kUsage, fmt::format("--seed {} is too large", *given), "give a smaller one");
  }
  if (given) seed = static_cast<std::int64_t>(*given);
  if (out.order != BatchOrder::given) out.seed = seed ? *seed : drawn_seed();
  return true;
}

Outcome<BatchRequest> BatchOptions::read(const Context& context, const std::string& db_path,
                                         std::optional<std::uint64_t> seed) const {
  BatchRequest out;
  auto text = read_text_file(file_);
  if (!text) return Failure(text.error(), "give another --batch");
  auto table = read_batch_table(*text, file_);
  if (!table) return Failure(table.error(), how_to_correct());
  Shelf shelf(context, db_path, out);
  BatchLookup lookup;
  lookup.protocol = [&shelf](const std::string& word) { return shelf.protocol(word); };
  lookup.specimen = [&shelf](const std::string& word) { return shelf.specimen(word); };
  auto rows = check_batch(*table, lookup);
  if (!rows) return Failure(rows.error(), how_to_correct());
  out.rows = std::move(*rows);
  auto terms = check_batch_terms(*table);
  if (!terms) return Failure(terms.error(), how_to_correct());
  out.terms = std::move(*terms);
  if (auto named = put_name(*table, out); !named) return named.error();
  if (auto ordered = put_order(*table, seed, out); !ordered) return ordered.error();
  out.file_name = std::filesystem::path(file_).filename().string();
  out.table = std::move(*text);
  return out;
}

}  // namespace lcrig::cli
