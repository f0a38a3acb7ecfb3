// SPDX-License-Identifier: Apache-2.0
// Removes what may have been measured from texts that leave the laboratory. Used by `lcrig doctor`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace lcrig::cli {

// Replaces every number by `#`, except that of a run or an entry and digits inside a name
// ("ttyUSB0"). "run 3: force 3.0110 N is outside" -> "run 3: force # N is outside".
std::string without_numbers(std::string_view text);
// For a journal in the form short-iso; time, computer and process stay.
std::string journal_without_numbers(std::string_view journal);
// The daemon's status without the last readings, and without numbers in reasons and prompts.
nlohmann::json status_without_values(nlohmann::json status);

}  // namespace lcrig::cli
