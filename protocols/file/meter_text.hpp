// SPDX-License-Identifier: Apache-2.0
// Changes the meter's settings in the text of a protocol, so that a run can use the frequency and
// the aperture that a budget proposes. The new text is stored with the run. Used by the command
// line and by tables of runs.
#pragma once

#include <string>
#include <string_view>

#include "protocols/file/parse.hpp"

namespace lcrig {

enum class MeterValue { none, frequency, aperture };

// Moves `frequency_Hz` and `aperture` from `values` into "sample"."lcr" of `text`, except those
// that the protocol has as parameters of its own. Errors: invalid_request, as parse_protocol;
// `*wrong` is then the value that was refused, or none when the text itself is bad. The parser of
// the new text checks the values.
Result<std::string> with_meter_values(std::string_view text, const std::string& name,
                                      ParameterValues& values, MeterValue* wrong = nullptr);

}  // namespace lcrig
