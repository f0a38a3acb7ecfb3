// SPDX-License-Identifier: Apache-2.0
#include "base/doc_page.hpp"

#include <unistd.h>

namespace lcrig {

std::string doc_page(std::string_view name) {
  return doc_page_in(LCRIG_DOC_FOLDER, name);
}

std::string doc_page_in(std::string_view folder, std::string_view name) {
  const std::string page = std::string(name) + ".md";
  std::string installed = std::string(folder) + "/" + page;
  return ::access(installed.c_str(), R_OK) == 0 ? installed : "docs/" + page;
}

}  // namespace lcrig
