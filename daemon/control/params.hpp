// SPDX-License-Identifier: Apache-2.0
// Reads one JSON object strictly: types are checked, nothing becomes a default silently. The
// control socket reads its requests with it, the queue its stored terms.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>

#include "base/result.hpp"
#include "base/text.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig {

// Reads members into fields; the first failure is kept and returned by `finish`. `object` must
// outlive the reader.
class ParamsReader {
 public:
  // `where` is the JSON pointer of the object, for messages: "/params".
  ParamsReader(const nlohmann::json& object, std::string where);

  // A member that is absent leaves `out` as it is, unless it is required.
  // `most`: if given, the text has at most so many bytes and no NUL (base/text.hpp).
  void text(const char* key, std::string& out, bool required = false, std::size_t most = SIZE_MAX);
  void integer(const char* key, std::int64_t& out, bool required = false);
  void number(const char* key, double& out, bool required = false);
  void boolean(const char* key, bool& out);
  // null and absent are both "no value". `power` converts to SI: 10^power.
  void quantity(const char* key, std::optional<double>& out, int power);
  // An object of numbers, or of strings that hold one as somebody typed it.
  void numbers(const char* key, ParameterValues& out);
  // The member for the caller to read, or nullptr when it is absent or null.
  const nlohmann::json* member(const char* key);
  std::string pointer(const char* key) const { return where_ + "/" + key; }
  void fail_with(Error error) {
    if (!error_) error_ = std::move(error);
  }

  // Refuses members that nobody asked for.
  void refuse_unknown();
  Result<> finish() const;

 private:
  const nlohmann::json* find(const char* key, bool required);
  void expected(const char* key, const char* what, const nlohmann::json& got);

  const nlohmann::json& object_;
  std::string where_;
  std::set<std::string> known_;
  std::optional<Error> error_;
};

}  // namespace lcrig
