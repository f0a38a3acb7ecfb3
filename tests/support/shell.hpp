// SPDX-License-Identifier: Apache-2.0
// Runs a line that calls `lcrig` as bash reads it.
#pragma once

#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace lcrig::support {

// The words after `lcrig`, as bash splits and unquotes the line. The line is written to `file`.
inline std::vector<std::string> read_by_shell(const std::string& file, const std::string& line) {
  std::ofstream(file) << line << '\n';
  const auto command = "bash -c 'lcrig() { printf \"%s\\0\" \"$@\"; }; . \"$0\"' '" + file + "'";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen(command.c_str(), "r"),
                                                             &::pclose);
  std::vector<std::string> out;
  std::string word;
  for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get())) {
    if (c != 0) {
      word += static_cast<char>(c);
    } else {
      out.push_back(std::move(word));
      word.clear();
    }
  }
  return out;
}

}  // namespace lcrig::support
