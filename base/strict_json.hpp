// SPDX-License-Identifier: Apache-2.0
// Strict JSON with positions, for every file format of lcrig: protocol, specimen, bench, config,
// fault script. A wrong file is always refused in the same form: `FILE:LINE:COLUMN /json/pointer:
// what was found, what was expected`.
//
// Strict means: `//` comments are the only addition to JSON. Refused are numbers beyond double,
// nesting beyond 64, more than 4 MiB or 100,000 values, keys beyond 200 bytes, anything after the
// value, and control characters and characters that reorder text. The last two are refused in
// comments too, because people are shown the comments. Duplicate keys are refused by the reader,
// together with all else that is wrong.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/enum_words.hpp"
#include "base/range.hpp"
#include "base/result.hpp"
#include "base/text_place.hpp"
#include "base/units.hpp"

namespace lcrig {

inline constexpr std::size_t kJsonSizeMax = 4 << 20;  // bytes
inline constexpr int kJsonDepthMax = 64;
// The position of every value is stored. These limits bound the memory that a small file can take.
inline constexpr std::size_t kJsonValuesMax = 100'000;
inline constexpr std::size_t kJsonKeyMax = 200, kJsonPointerMax = 1000;  // bytes

// A parsed file; immutable and cheap to copy.
class JsonDocument {
 public:
  // Every error is invalid_request and one printable line, which calls the text `name`.
  static Result<JsonDocument> parse(std::string_view text, std::string name);

  const nlohmann::json& root() const;
  const std::string& name() const;
  // Where the value of `pointer` begins, or its key.
  TextPosition value_position(const std::string& pointer) const;
  TextPosition key_position(const std::string& pointer) const;
  std::string_view text() const;
  // The number at `pointer` as the file writes it.
  std::string number_text(const std::string& pointer) const;
  // A key that an object contains twice, and the words that say so. Every JsonReader of the
  // document fails then.
  struct Duplicate {
    std::string pointer, what;
    TextPosition at;
  };
  const std::vector<Duplicate>& duplicates() const;

 private:
  struct Data;
  friend class JsonParser;
  std::shared_ptr<const Data> data_;
};

// Reads a whole file of at most kJsonSizeMax. Errors: io (with the path and the reason).
Result<std::string> read_text_file(const std::string& path);
// Refuses pipes, devices and folders: reading a pipe waits for its writer. For files that a daemon
// reads, or that must still be there when they are read again. A missing file is not refused.
Result<> require_plain_file(const std::string& path);
// read_text_file and JsonDocument::parse.
Result<JsonDocument> load_json(const std::string& path);

struct QuantityField;

// A typed view of one value of a document. All readers of a document share its failures: read
// everything, then check `result()` before using any of it. Its error is the first failure;
// `detail` shows the line, and lists the other values of a wrong type, range or name. After a
// failure the functions return harmless values (0, "", empty), which must not be used.
class JsonReader {
 public:
  explicit JsonReader(const JsonDocument& document);

  bool ok() const;  // no reader of the document has failed so far
  bool sound() const;  // neither this value, nor one inside or around it, is wrong
  Result<> result() const;
  const std::string& pointer() const { return pointer_; }
  std::string last_key() const;  // last part of the pointer, without escapes

  // Refuses this value: `found_and_expected` follows "FILE:LINE:COL /pointer: ". Does nothing when
  // the value is not `sound`. A caller whose judgement depends on other values must check that they
  // are sound, too: after a failure they are harmless replacements.
  void refuse(const std::string& found_and_expected) const;
  void refuse_key(const std::string& found_and_expected) const;  // position of the key

  bool is_object() const;
  bool is_array() const;
  bool is_string() const;
  bool is_number() const;
  bool is_boolean() const;
  bool is_null() const;

  // This value as the named type; refused when it has another type.
  double number(const Range& range = kAnyNumber) const;
  double number_in(double to_si, const Range& si) const;  // value * to_si, in SI
  std::int64_t integer(std::int64_t min, std::int64_t max) const;  // accepts 5.0, not 5.5
  bool boolean() const;
  std::string string() const;
  std::string nonempty_string(std::size_t max_bytes = 200) const;
  std::vector<JsonReader> items(std::size_t min = 0, std::size_t max = SIZE_MAX) const;
  template <class E>
  E word(std::span<const std::pair<std::string_view, E>> table) const;
  template <HasWords E>
  E word() const {
    return word<E>(word_table<E>());
  }

  // Members of this object. Asking for a key makes it known to `no_other_keys`.
  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;
  std::optional<JsonReader> find(std::string_view key) const;
  JsonReader at(std::string_view key) const;  // refused when absent
  JsonReader object(std::string_view key) const;
  std::vector<JsonReader> members() const;  // all, at most 1000; for objects whose keys are names
                                            // chosen by the user

  double number(std::string_view key, const Range& range = kAnyNumber) const;
  std::int64_t integer(std::string_view key, std::int64_t min, std::int64_t max) const;
  bool boolean(std::string_view key) const;
  std::string string(std::string_view key) const;
  std::optional<double> optional_number(std::string_view key, const Range& r = kAnyNumber) const;
  std::optional<std::int64_t> optional_integer(std::string_view key, std::int64_t min,
                                               std::int64_t max) const;
  std::optional<bool> optional_boolean(std::string_view key) const;
  std::optional<std::string> optional_string(std::string_view key) const;
  template <class E>
  E word(std::string_view key, std::span<const std::pair<std::string_view, E>> table) const {
    return at(key).word(table);
  }
  template <HasWords E>
  E word(std::string_view key) const {
    return at(key).word<E>();
  }

  // A number whose key ends in a unit: quantity("thickness", Dimension::length) takes
  // "thickness_um" or "thickness_mm" and returns metres. `range` is in SI. Two such keys in one
  // object are refused.
  double quantity(std::string_view stem, Dimension d, const Range& range = kAnyNumber) const;
  std::optional<double> optional_quantity(std::string_view stem, Dimension d,
                                          const Range& range = kAnyNumber) const;
  // The member itself, for quantities that are not plain numbers.
  std::optional<QuantityField> find_quantity(std::string_view stem, Dimension d) const;

  // Refuses every key that was not asked for, and lists the known ones. Call it last on an object,
  // after asking for all keys.
  void no_other_keys() const;
  // Refuses the document unless "format" is `expected`, e.g. "specimen/1". Other failures of a file
  // in another format are not reported.
  void expect_format(std::string_view expected) const;

 private:
  struct State;
  struct Known;
  JsonReader(std::shared_ptr<State> state, const nlohmann::json& value, std::string pointer);
  JsonReader child(const nlohmann::json& value, std::string_view key) const;
  void missing(std::string_view key, const std::string& what,
               std::vector<std::string> accepted) const;
  void forget_own() const;
  bool stands_for_missing(const JsonReader& unknown, const std::string& meant) const;
  bool is_related_failure(std::string_view pointer) const;
  void add(std::string about, TextPosition at, const std::string& what,
           std::vector<std::string> absent) const;
  std::size_t word_index(std::span<const std::string> words) const;
  std::string shown() const;
  void know(std::string_view key, std::string display) const;

  std::shared_ptr<State> state_;
  const nlohmann::json* value_;
  std::string pointer_;
  std::shared_ptr<Known> known_;
};

struct QuantityField {
  JsonReader value;
  std::string key;
  Unit unit;
};

template <class E>
E JsonReader::word(std::span<const std::pair<std::string_view, E>> table) const {
  std::vector<std::string> words;
  for (const auto& [text, value] : table) words.emplace_back(text);
  return table[word_index(words)].second;
}

}  // namespace lcrig
