// SPDX-License-Identifier: Apache-2.0
// Finds a page of the documentation for messages that refer a person to it. Every such message uses
// this function.
#pragma once

#include <string>
#include <string_view>

namespace lcrig {

// "lab-setup" gives "/usr/share/doc/lcrig/docs/lab-setup.md", or "docs/lab-setup.md" in the sources
// where no documentation is installed.
std::string doc_page(std::string_view name);
// The same with another folder of installed documentation; for tests.
std::string doc_page_in(std::string_view folder, std::string_view name);

}  // namespace lcrig
