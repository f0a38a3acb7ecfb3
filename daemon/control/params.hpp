// SPDX-License-Identifier: Apache-2.0
// Reads one JSON object strictly: types are checked, and wrong values never become defaults. The
// control socket reads its requests with it, and the queue its stored terms.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/enum_words.hpp"
#include "base/result.hpp"
#include "base/text.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig {

struct RunRequest;

// Reads members into variables. It keeps the first failure, and `finish` returns it. `object` must
// outlive the reader.
class ParamsReader {
 public:
  // `where` is the JSON pointer of the object in messages: "/params".
  ParamsReader(const nlohmann::json& object, std::string where);

  // An absent member leaves `out` unchanged, unless it is required.
  // `most`: if given, the text has at most so many bytes and no NUL (base/text.hpp).
  void text(const char* key, std::string& out, bool required = false, std::size_t most = SIZE_MAX);
  // The same, with null for the empty text.
  void text_or_null(const char* key, std::string& out);
  void text_or_absent(const char* key, std::string& out, std::size_t most = SIZE_MAX) {
    text(key, out, false, most);
  }
  void texts(const char* key, std::vector<std::string>& out);
  void integer(const char* key, std::int64_t& out, bool required = false);
  // null and absent both mean "no value".
  void integer(const char* key, std::optional<std::int64_t>& out);
  void number(const char* key, double& out, bool required = false);
  void boolean(const char* key, bool& out);
  // null and absent both mean "no value". `power` converts to SI: 10^power.
  void quantity(const char* key, std::optional<double>& out, int power);
  // An object of numbers, or of strings with a number as a person typed it.
  void numbers(const char* key, ParameterValues& out);
  // A word of an enumeration.
  template <HasWords E>
  void word(const char* key, E& out, bool required = false) {
    std::string text(to_string(out));
    this->text(key, text, required);
    const auto known = parse_word<E>(text);
    if (!known) return expected_word(key, all_words<E>());
    out = *known;
  }
  // The same, with null for no word.
  template <HasWords E>
  void word_or_null(const char* key, std::optional<E>& out) {
    std::string text;
    text_or_null(key, text);
    if (text.empty()) return;
    word(key, out.emplace());
  }
  // The same, with the empty word, or an unknown word of a newer daemon, for no value.
  template <HasWords E>
  void word_or_empty(const char* key, std::optional<E>& out) {
    std::string text;
    this->text(key, text);
    out = parse_word<E>(text);
  }
  // An object. `fill` reads it, or `fields` lists its members (fields.hpp).
  template <class T, class Fill>
  void object(const char* key, std::optional<T>& out, Fill fill) {
    if (member(key) != nullptr) inside(key, [&](ParamsReader& f) { fill(f, out.emplace()); });
  }
  template <class T>
  void object(const char* key, std::optional<T>& out) {
    object(key, out, [](ParamsReader& f, T& inner) { fields(f, inner); });
  }
  template <class T>
  void list(const char* key, std::vector<T>& out) {
    each(key, [&out](ParamsReader& f) { fields(f, out.emplace_back()); });
  }
  // The member itself; nullptr when it is absent or null.
  const nlohmann::json* member(const char* key);
  std::string pointer(const char* key) const { return where_ + "/" + key; }
  void fail_with(Error error) {
    if (!error_) error_ = std::move(error);
  }
  // Refuses a member with a reason such as "expected 1 to 100".
  void refuse(const char* key, std::string_view why) {
    fail_with(Error(Errc::invalid_request, fmt::format("{}: {}", pointer(key), why)));
  }

  // Refuses members that were not asked for.
  void refuse_unknown();
  Result<> finish() const;

 private:
  const nlohmann::json* find(const char* key, bool required);
  void expected(const char* key, const char* what, const nlohmann::json& got);
  void expected_word(const char* key, const std::vector<std::string>& words);
  using Read = std::function<void(ParamsReader&)>;
  void inside(const char* key, const Read& read);
  void each(const char* key, const Read& read);

  const nlohmann::json& object_;
  std::string where_;
  std::set<std::string> known_;
  std::optional<Error> error_;
};

// Reads the members of a RunRequest; messages.cpp writes them.
void read_run_request(ParamsReader& in, RunRequest& out);

}  // namespace lcrig
