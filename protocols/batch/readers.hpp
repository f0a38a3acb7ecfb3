// SPDX-License-Identifier: Apache-2.0
// Reads the two forms of a table of runs, CSV and JSON; table.cpp chooses.
#pragma once

#include <string>
#include <string_view>

#include "protocols/batch/table.hpp"

namespace lcrig {

// `text` is UTF-8. Errors: invalid_request.
Result<BatchTable> read_batch_csv(std::string_view text, const std::string& source);
Result<BatchTable> read_batch_json(std::string_view text, const std::string& source);

}  // namespace lcrig
