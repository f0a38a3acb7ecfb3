// SPDX-License-Identifier: Apache-2.0
#include "base/doc_page.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

namespace fs = std::filesystem;

TEST(DocPage, IsTheInstalledOneWhereThereIsOne) {
  const TempDir dir;
  EXPECT_EQ(doc_page_in(dir.file("docs"), "lab-setup"), "docs/lab-setup.md");
  fs::create_directory(dir.file("docs"));
  std::ofstream(dir.file("docs/lab-setup.md")) << "# Lab setup\n";
  EXPECT_EQ(doc_page_in(dir.file("docs"), "lab-setup"), dir.file("docs/lab-setup.md"));
  EXPECT_EQ(doc_page_in(dir.file("docs"), "faults"), "docs/faults.md");
}

// Of the programs that people start. Whoever writes a client of the daemon has the sources.
TEST(DocPage, IsWhatEveryMessageNames) {
  const std::regex literal("\"[^\"\n]*docs/[a-z-]+\\.md"), call("doc_page\\(\"([a-z-]+)\"\\)");
  int pages = 0;
  for (const char* folder : {"tools/lcrig", "tools/lcrig-sim", "drivers", "protocols", "model"}) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() != ".cpp") continue;
      std::ifstream file(entry.path());
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      EXPECT_FALSE(std::regex_search(text, literal)) << entry.path();
      for (std::sregex_iterator i(text.begin(), text.end(), call), end; i != end; ++i) {
        EXPECT_TRUE(fs::exists("docs/" + (*i)[1].str() + ".md")) << entry.path() << (*i)[1];
        ++pages;
      }
    }
  }
  EXPECT_GE(pages, 10);
}

}  // namespace
}  // namespace lcrig
