// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/argument_table.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace lcrig::cli {

namespace {

std::vector<std::string> split_names(std::string_view names) {
  std::vector<std::string> out;
  while (!names.empty()) {
    const auto comma = std::min(names.find(','), names.size());
    out.emplace_back(names.substr(0, comma));
    names.remove_prefix(std::min(comma + 1, names.size()));
  }
  return out;
}

class Table final : public ArgumentList {
 public:
  void positional(Placeholder name, std::string&, const char* help, bool required) override {
    Argument& a = add(name.word, name, help);
    a.option = false;
    a.required = required;
  }
  void words(Placeholder name, std::vector<std::string>&, const char* help,
             bool required) override {
    Argument& a = add(name.word, name, help);
    a.option = false;
    a.required = required;
    a.repeats = true;
  }
  void option(const char* names, std::string&, Placeholder value, const char* help,
              bool required) override {
    add(names, value, help).required = required;
  }
  void options(const char* names, std::vector<std::string>&, Placeholder value,
               const char* help) override {
    add(names, value, help).repeats = true;
  }
  void seed(const char* names, std::optional<std::uint64_t>&, const char* help) override {
    add(names, "N", help);
  }
  void number(const char* names, std::function<void(double)>, const char* metavar,
              const char* help) override {
    add(names, metavar, help);
  }
  void one_of(const char* names, std::string&, const std::vector<std::string>& choices,
              const char* help) override {
    const auto words = fmt::format("{}", fmt::join(choices, "|"));
    add(names, words.c_str(), help).choices = choices;
  }
  void flag(const char* names, bool&, const char* help) override { add(names, "", help); }

  std::vector<Argument> take() { return std::move(arguments_); }

 private:
  Argument& add(const char* names, Placeholder value, const char* help) {
    Argument& a = arguments_.emplace_back();
    a.names = split_names(names);
    a.value = value.word;
    a.proposes = value.proposes;
    a.help = help;
    return a;
  }
  std::vector<Argument> arguments_;
};

}  // namespace

std::vector<Argument> arguments_of(Command& command) {
  Table table;
  command.declare(table);
  return table.take();
}

std::vector<Argument> global_arguments() {
  Table table;
  GlobalOptions unused;
  declare_global(table, unused);
  return table.take();
}

}  // namespace lcrig::cli
