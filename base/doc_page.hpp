// SPDX-License-Identifier: Apache-2.0
// Where a person finds a page of the documentation. Every message that sends somebody to a page
// names it by this.
#pragma once

#include <string>
#include <string_view>

namespace lcrig {

// "/usr/share/doc/lcrig/docs/lab-setup.md" of "lab-setup"; where no documentation is installed, the
// place in the sources: "docs/lab-setup.md".
std::string doc_page(std::string_view name);
// The same with another folder of installed documentation; for tests.
std::string doc_page_in(std::string_view folder, std::string_view name);

}  // namespace lcrig
