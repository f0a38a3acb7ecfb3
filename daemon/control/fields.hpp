// SPDX-License-Identifier: Apache-2.0
// Writes and reads messages by one list of their members. A function `fields(f, message)` lists
// them: with a FieldWriter it writes the message, with a ParamsReader it reads it. Both have the
// same calls. Used by messages.cpp, queue_messages.cpp, config_view.cpp and the terms of the queue.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "daemon/control/params.hpp"

namespace lcrig {

// Writes into an object, which must outlive it. It ignores arguments for readers: whether a member
// is required, and the longest text.
class FieldWriter {
 public:
  explicit FieldWriter(nlohmann::json& object) : out_(object) {}

  void put(const char* key, nlohmann::json value);
  void text(const char* key, std::string_view v, bool = false, std::size_t = 0);
  void text_or_null(const char* key, std::string_view v);
  void text_or_absent(const char* key, const std::string& v, std::size_t = 0);
  void texts(const char* key, const std::vector<std::string>& v);
  void integer(const char* key, std::int64_t v, bool = false);
  void integer(const char* key, const std::optional<std::int64_t>& v);
  void number(const char* key, double v, bool = false);
  void boolean(const char* key, bool v);
  void quantity(const char* key, const std::optional<double>& si, int power);
  void numbers(const char* key, const ParameterValues& v);
  template <HasWords E>
  void word(const char* key, E v, bool = false) {
    text(key, to_string(v));
  }
  template <HasWords E>
  void word_or_empty(const char* key, const std::optional<E>& v) {
    text(key, v ? to_string(*v) : "");
  }
  template <HasWords E>
  void word_or_null(const char* key, const std::optional<E>& v) {
    text_or_null(key, v ? to_string(*v) : "");
  }
  template <class T, class Fill>
  void object(const char* key, const std::optional<T>& v, Fill fill) {
    text_or_null(key, "");
    if (!v) return;
    FieldWriter inner = inside(key);
    fill(inner, *v);
  }
  template <class T>
  void object(const char* key, const std::optional<T>& v) {
    object(key, v, [](FieldWriter& f, const T& inner) { fields(f, inner); });
  }
  template <class T>
  void list(const char* key, const std::vector<T>& all) {
    texts(key, {});
    for (const T& each : all) {
      FieldWriter inner = item(key);
      fields(inner, each);
    }
  }

 private:
  FieldWriter inside(const char* key);
  FieldWriter item(const char* key);

  nlohmann::json& out_;
};

// The parameter type of `fields`: const when the message is written.
template <class F, class T>
using Of = std::conditional_t<std::is_same_v<F, FieldWriter>, const T, T>;

template <class T, class Json = nlohmann::json>
Json written(const T& message) {
  Json out = Json::object();
  FieldWriter writer(out);
  fields(writer, message);
  return out;
}

// Reads an answer or a notification. Errors: garbled, with the JSON pointer.
template <class T>
Result<T> read_answer(const nlohmann::json& value) {
  T out{};
  ParamsReader in(value, "");
  fields(in, out);
  if (auto done = in.finish(); !done) return fail(Errc::garbled, "{}", done.error().what);
  return out;
}

// Reads the params of a request. Errors: invalid_request, with the JSON pointer; unknown members
// are refused, too.
template <class T, class Fill>
Result<T> read_params(const nlohmann::json& params, Fill fill) {
  T out{};
  ParamsReader in(params, "/params");
  fill(in, out);
  in.refuse_unknown();
  if (auto done = in.finish(); !done) return fail(done.error());
  return out;
}
template <class T>
Result<T> read_params(const nlohmann::json& params) {
  return read_params<T>(params, [](ParamsReader& in, T& out) { fields(in, out); });
}

}  // namespace lcrig
