// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/key_words.hpp"
#include "base/near_word.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"

namespace lcrig {

using nlohmann::json;

struct JsonReader::State {
  explicit State(JsonDocument d) : document(std::move(d)) {}
  struct Failure {
    std::string pointer;  // of the value that is wrong, which may be absent
    TextPosition at;
    std::string what;
    std::vector<std::string> absent;  // the keys of which one was expected there
  };
  JsonDocument document;
  std::vector<Failure> failures;
};

struct JsonReader::Known {
  std::vector<std::string> keys;  // that the object may contain
  std::vector<std::string> shown;  // the same, as messages show them
};

namespace {

// The value of readers that have failed.
const json& nothing() {
  static const json kNothing;
  return kNothing;
}

std::string counted(std::size_t items) {
  return items == 1 ? "1 item" : fmt::format("{} items", items);
}

std::string count_words(std::size_t min, std::size_t max) {
  if (max == SIZE_MAX) return fmt::format("at least {}", min);
  return min == max ? fmt::format("{}", min) : fmt::format("{} to {}", min, max);
}

// JSON reads [-0.2, 1,5] as three numbers. Many people mean two, with a decimal comma. The missing
// blank after the comma shows it.
std::string comma_doubt(const JsonDocument& document, const std::string& list, std::size_t min,
                        std::size_t max) {
  const std::size_t size = document.root()[json::json_pointer(list)].size();
  const auto digits = [](std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == text.npos;
  };
  std::string first;
  std::size_t left = size;
  for (std::size_t i = 0; i + 1 < size; ++i) {
    const auto here = fmt::format("{}/{}", list, i), next = fmt::format("{}/{}", list, i + 1);
    const TextPosition at = document.value_position(here), then = document.value_position(next);
    const auto whole = document.number_text(here), fraction = document.number_text(next);
    const bool close =
        at.line == then.line && then.column == at.column + static_cast<int>(whole.size()) + 1;
    if (!close || !digits(fraction)) continue;
    if (!digits(whole.starts_with('-') ? whole.substr(1) : whole)) continue;
    if (first.empty()) first = whole + "." + fraction;
    --left;
    ++i;
  }
  if (first.empty() || left < min || left > max) return {};
  return fmt::format("; is a decimal comma among them? A number has a point: {}", first);
}

std::string list_size_words(const JsonDocument& document, const std::string& pointer,
                            std::size_t min, std::size_t max) {
  const std::size_t size = document.root()[json::json_pointer(pointer)].size();
  return fmt::format("{}, expected {}{}", counted(size), count_words(min, max),
                     size > max ? comma_doubt(document, pointer, min, max) : std::string());
}

std::string escaped(std::string_view key) {
  json::json_pointer p;
  p.push_back(std::string(key));
  return p.to_string();
}

// "thickness_(um|mm|m)": how messages list the keys of a quantity.
std::string key_pattern(std::string_view stem, Dimension d) {
  std::string out;
  for (const Unit& unit : all_units()) {
    if (unit.dimension == d) out += fmt::format("{}{}", out.empty() ? "" : "|", unit.suffix);
  }
  return fmt::format("{}_({})", stem, out);
}

// Whether `pointer` is `parent` or lies in it: /steps/10 is not in /steps/1.
bool is_within(std::string_view pointer, std::string_view parent) {
  return pointer.starts_with(parent) &&
         (pointer.size() == parent.size() || pointer[parent.size()] == '/');
}

std::string located(const JsonDocument& doc, TextPosition at, const std::string& pointer,
                    const std::string& what) {
  return fmt::format("{}:{}:{} {}: {}", doc.name(), at.line, at.column,
                     pointer.empty() ? "/" : printable(pointer, 200), printable(what, 2000));
}

}  // namespace

JsonReader::JsonReader(const JsonDocument& document)
    : state_(std::make_shared<State>(document)),
      value_(&state_->document.root()),
      known_(std::make_shared<Known>()) {
  for (const auto& d : document.duplicates()) {
    if (is_related_failure(d.pointer)) continue;
    state_->failures.push_back(
        {d.pointer, d.at, located(state_->document, d.at, d.pointer, d.what), {}});
  }
}

JsonReader::JsonReader(std::shared_ptr<State> state, const json& value, std::string pointer)
    : state_(std::move(state)),
      value_(&value),
      pointer_(std::move(pointer)),
      known_(std::make_shared<Known>()) {}

JsonReader JsonReader::child(const json& value, std::string_view key) const {
  return JsonReader(state_, value, pointer_ + escaped(key));
}

bool JsonReader::ok() const {
  return state_->failures.empty();
}

bool JsonReader::sound() const {
  return !is_related_failure(pointer_);
}

bool JsonReader::is_related_failure(std::string_view pointer) const {
  return std::ranges::any_of(state_->failures, [pointer](const State::Failure& f) {
    return is_within(pointer, f.pointer) || is_within(f.pointer, pointer);
  });
}

// Lists failures in the order of the file, because people correct a file from its top.
Result<> JsonReader::result() const {
  std::vector<TextPosition> places;
  for (const auto& f : state_->failures) places.push_back(f.at);
  return refuse_at(state_->document.text(), places,
                   [this](std::size_t i) { return state_->failures[i].what; });
}

std::string JsonReader::last_key() const {
  return pointer_.empty() ? std::string() : json::json_pointer(pointer_).back();
}

// Adds at most one failure for a value, its parents and its children. A later one may only be a
// consequence of the first.
void JsonReader::add(std::string about, TextPosition at, const std::string& what,
                     std::vector<std::string> absent) const {
  constexpr std::size_t kMost = 200;  // nobody reads more, and each new one is compared with all
  if (state_->failures.size() >= kMost || is_related_failure(about)) return;
  state_->failures.push_back(
      {std::move(about), at, located(state_->document, at, pointer_, what), std::move(absent)});
}

void JsonReader::refuse(const std::string& what) const {
  add(pointer_, state_->document.value_position(pointer_), what, {});
}

void JsonReader::refuse_key(const std::string& what) const {
  add(pointer_, state_->document.key_position(pointer_), what, {});
}

void JsonReader::know(std::string_view key, std::string display) const {
  known_->keys.emplace_back(key);
  if (std::ranges::find(known_->shown, display) == known_->shown.end()) {
    known_->shown.push_back(std::move(display));
  }
}

bool JsonReader::has(std::string_view key) const {
  return find(key).has_value();
}

std::vector<std::string> JsonReader::keys() const {
  std::vector<std::string> out;
  if (!is_object()) return out;
  for (const auto& [key, value] : value_->items()) out.push_back(key);
  return out;
}

std::optional<JsonReader> JsonReader::find(std::string_view key) const {
  know(key, std::string(key));
  if (!is_object()) {
    refuse(fmt::format("{}, expected an object", shown()));
    return std::nullopt;
  }
  const auto it = value_->find(std::string(key));
  if (it == value_->end()) return std::nullopt;
  return child(*it, key);
}

void JsonReader::missing(std::string_view key, const std::string& what,
                         std::vector<std::string> accepted) const {
  add(pointer_ + escaped(key), state_->document.value_position(pointer_),
      fmt::format("{} is missing{}{}", what, value_->empty() ? "" : ", found ",
                  fmt::join(keys(), ", ")),
      std::move(accepted));
}

// Removes failures of the object as a whole, such as a missing speed. The mistyped key, which is
// reported instead, explains them.
void JsonReader::forget_own() const {
  std::erase_if(state_->failures,
                [this](const State::Failure& f) { return f.pointer == pointer_; });
}

// Merges an unknown key and the missing key that it was meant to be into one failure. False: there
// is no such missing key.
bool JsonReader::stands_for_missing(const JsonReader& unknown, const std::string& meant) const {
  for (State::Failure& f : state_->failures) {
    if (std::ranges::find(f.absent, meant) == f.absent.end()) continue;
    if (!is_within(f.pointer, pointer_) ||
        f.pointer.find('/', pointer_.size() + 1) != f.pointer.npos) {
      continue;
    }
    f.at = state_->document.key_position(unknown.pointer_);
    f.what = located(state_->document, f.at, unknown.pointer_,
                     fmt::format("unknown key `{}`{} It is missing", printable(unknown.last_key()),
                                 guess_words(meant)));
    return true;
  }
  return false;
}

JsonReader JsonReader::at(std::string_view key) const {
  if (auto found = find(key)) return *found;
  missing(key, fmt::format("the key `{}`", key), {std::string(key)});
  return JsonReader(state_, nothing(), pointer_ + escaped(key));
}

JsonReader JsonReader::object(std::string_view key) const {
  JsonReader r = at(key);
  if (!r.is_object()) r.refuse(fmt::format("{}, expected an object", r.shown()));
  return r;
}

std::vector<JsonReader> JsonReader::items(std::size_t min, std::size_t max) const {
  std::vector<JsonReader> out;
  if (!is_array()) {
    refuse(fmt::format("{}, expected a list in square brackets", shown()));
    return out;
  }
  if (value_->size() < min || value_->size() > max) {
    refuse(list_size_words(state_->document, pointer_, min, max));
    return out;
  }
  std::size_t i = 0;
  for (const json& item : *value_) out.push_back(child(item, std::to_string(i++)));
  return out;
}

std::vector<JsonReader> JsonReader::members() const {
  std::vector<JsonReader> out;
  if (!is_object()) {
    refuse(fmt::format("{}, expected an object", shown()));
    return out;
  }
  constexpr std::size_t kMost = 1000;
  if (value_->size() > kMost) {
    refuse(fmt::format("{} members, expected at most {}", value_->size(), kMost));
    return out;
  }
  for (const auto& [key, value] : value_->items()) {
    know(key, key);
    out.push_back(child(value, key));
  }
  return out;
}

std::optional<QuantityField> JsonReader::find_quantity(std::string_view stem, Dimension d) const {
  for (const Unit& unit : all_units()) {
    if (unit.dimension == d) know(fmt::format("{}_{}", stem, unit.suffix), key_pattern(stem, d));
  }
  std::optional<QuantityField> found;
  for (const std::string& key : keys()) {
    const KeyParts parts = split_key(key);
    if (!parts.unit || parts.stem != stem || parts.dimension() != d) continue;
    JsonReader value = child((*value_)[key], key);
    if (found) {
      value.refuse_key(fmt::format("`{}` beside `{}`, expected only one of them", key, found->key));
    }
    found = QuantityField{std::move(value), key, *parts.unit};
  }
  return found;
}

std::optional<double> JsonReader::optional_quantity(std::string_view stem, Dimension d,
                                                    const Range& range) const {
  const auto field = find_quantity(stem, d);
  if (!field) return std::nullopt;
  return field->value.number_in(field->unit.to_si, range);
}

double JsonReader::quantity(std::string_view stem, Dimension d, const Range& range) const {
  if (const auto v = optional_quantity(stem, d, range)) return *v;
  std::vector<std::string> accepted;
  for (const Unit& unit : all_units()) {
    if (unit.dimension == d) accepted.push_back(fmt::format("{}_{}", stem, unit.suffix));
  }
  for (const std::string& key : keys()) {
    if (key != stem && !key.starts_with(std::string(stem) + "_")) continue;
    const auto words = unit_mistake(key, accepted);
    if (!words) continue;
    child((*value_)[key], key).refuse_key(*words);
    return 0;
  }
  missing(stem, fmt::format("`{}` with a unit of {} ({})", stem, to_string(d), suffixes_of(d)),
          std::move(accepted));
  return 0;
}

void JsonReader::no_other_keys() const {
  std::vector<std::string> absent;
  const auto present = keys();
  std::ranges::copy_if(known_->keys, std::back_inserter(absent), [&](const std::string& key) {
    return std::ranges::find(present, key) == present.end();
  });
  for (const std::string& key : present) {
    if (std::ranges::find(known_->keys, key) != known_->keys.end()) continue;
    const JsonReader unknown = child((*value_)[key], key);
    if (const auto words = unit_mistake(key, known_->keys)) {
      forget_own();
      unknown.refuse_key(*words);
      continue;
    }
    auto meant = nearest_key(key, absent);
    if (!meant) meant = nearest_key(key, known_->keys);
    if (meant) forget_own();
    if (meant && stands_for_missing(unknown, *meant)) continue;
    return unknown.refuse_key(fmt::format("unknown key `{}`{} expected {}", printable(key),
                                          or_comma(guess_words(meant)),
                                          fmt::join(known_->shown, ", ")));
  }
}

void JsonReader::expect_format(std::string_view expected) const {
  const JsonReader format = at("format");
  if (format.string() == expected || !format.is_string()) return;
  format.add(pointer_, state_->document.value_position(format.pointer_),
             fmt::format("{}, expected \"{}\"", format.shown(), expected), {});
}

}  // namespace lcrig
