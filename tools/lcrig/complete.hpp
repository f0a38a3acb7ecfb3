// SPDX-License-Identifier: Apache-2.0
// Proposes words for the place of the cursor: `lcrig __complete -- WORD...`, for the shells'
// completions in tools/completion/. Never fails loudly: files and databases that cannot be read
// have no names.
#pragma once

#include <string>
#include <vector>

#include "tools/lcrig/process_env.hpp"

namespace lcrig::cli {

// `words`: what was typed behind `lcrig`; the last one is the one to complete, and may be empty.
// The first line says which files may stand there as well: "none", "file", "json" or "dir". Each
// other line is a whole word, a tab, and what it is.
std::string complete(const ProcessEnv& env, const std::vector<std::string>& words);

}  // namespace lcrig::cli
