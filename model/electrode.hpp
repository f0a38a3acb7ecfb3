// SPDX-License-Identifier: Apache-2.0
// Chooses which area carries the charge when an electrode is stretched. An option of the
// finite-element levels (level.hpp).
#pragma once

#include <optional>
#include <string_view>

namespace lcrig {

// reference: the printed disc. deformed: the stretched upper electrode, as a field solver on the
// deformed mesh sees it.
enum class ElectrodeArea { reference, deformed };
std::string_view to_string(ElectrodeArea area);
std::optional<ElectrodeArea> parse_electrode_area(std::string_view text);

}  // namespace lcrig
