// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/command_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/text.hpp"

namespace lcrig::cli {

namespace {

bool is_plain(char c) {
  constexpr std::string_view kPlain = "_@%+=:,./-";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         kPlain.find(c) != std::string_view::npos;
}

// $'a\nb': only printable ASCII stays as it is.
std::string escaped_for_shell(std::string_view word) {
  std::string out = "$'";
  for (const char c : word) {
    if (c == '\'' || c == '\\') {
      out += {'\\', c};
    } else if (c >= ' ' && c <= '~') {
      out += c;
    } else {
      out += fmt::format("\\{:03o}", static_cast<unsigned char>(c));
    }
  }
  return out + "'";
}

Words words_of(const GlobalOptions& global) {
  Words words;
  add_option(words, "--db", global.db);
  add_option(words, "--socket", global.socket);
  add_option(words, "--config", global.config);
  return words;
}

std::string typed(const Words& words) {
  std::string out;
  for (const auto& word : words) out += (out.empty() ? "" : " ") + shell_quoted(word);
  return out;
}

}  // namespace

std::string shell_quoted(std::string_view word) {
  if (!word.empty() && std::ranges::all_of(word, is_plain)) return std::string(word);
  if (printable(word) != word) return escaped_for_shell(word);
  std::string out = "'";
  for (const char c : word) {
    if (c == '\'') {
      out += "'\\''";
    } else {
      out += c;
    }
  }
  return out + "'";
}

void add_option(Words& words, const char* name, const std::string& value) {
  if (value.empty()) return;
  const std::string_view long_name(name);
  // A value that begins with '-' would be taken for an option. A long name can be joined to it by
  // '='.
  if (value.size() > 1 && value.front() == '-' && long_name.starts_with("--")) {
    words.push_back(fmt::format("{}={}", long_name, value));
    return;
  }
  words.emplace_back(long_name);
  words.push_back(value);
}

void add_options(Words& words, const char* name, const std::vector<std::string>& values) {
  for (const auto& value : values) add_option(words, name, value);
}

void add_flag(Words& words, const char* name, bool given) {
  if (given) words.emplace_back(name);
}

GlobalOptions at_database(const std::string& path) {
  GlobalOptions out;
  out.db = path;
  return out;
}

GlobalOptions for_rehearsal(const Context& context, const std::string& path) {
  return context.env.rehearsal_db() == path ? GlobalOptions() : at_database(path);
}

std::string given_options(const GlobalOptions& global) {
  return typed(words_of(global));
}

std::string next_command(const GlobalOptions& global, const Words& words, std::string_view note) {
  std::string out = "lcrig " + typed(words);
  if (const auto given = given_options(global); !given.empty()) out += " " + given;
  return note.empty() ? out : fmt::format("{}   ({})", out, note);
}

// JSON escapes only ASCII control characters. Some terminals also obey U+0080..9F, and all of them
// obey characters that reorder text.
std::string json_line(const nlohmann::json& value) {
  const std::string text = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size() + 1);
  constexpr auto is_plain = [](char c) { return c >= ' ' && c <= '~'; };
  for (std::string_view rest = text; !rest.empty();) {
    // Nearly everything is plain, so whole stretches are copied at once.
    const auto plain = std::ranges::find_if_not(rest, is_plain) - rest.begin();
    safe += rest.substr(0, static_cast<std::size_t>(plain));
    rest.remove_prefix(static_cast<std::size_t>(plain));
    if (rest.empty()) break;
    const std::string_view before = rest;
    const char32_t c = take_character(rest);
    if (is_steering(c)) {
      safe += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      safe += before.substr(0, before.size() - rest.size());
    }
  }
  return safe;
}

void print_json(std::ostream& out, const nlohmann::json& value) {
  out << json_line(value) << '\n';
}

ExitCode show(Context& context, const nlohmann::json& result,
              const std::function<void(std::ostream&)>& text) {
  if (context.global.json) {
    print_json(context.console.out, result);
  } else {
    text(context.console.out);
  }
  return kOk;
}

}  // namespace lcrig::cli
