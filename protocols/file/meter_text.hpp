// SPDX-License-Identifier: Apache-2.0
// Changes the meter's settings in the text of a protocol, so that a run can be asked for with the
// frequency and the aperture that a budget proposes. The new text is stored with the run. The
// command line and tables of runs use it.
#pragma once

#include <string>
#include <string_view>

#include "protocols/file/parse.hpp"

namespace lcrig {

enum class MeterValue { none, frequency, aperture };

// Takes `frequency_Hz` and `aperture` out of `values` and puts them into "sample"."lcr" of `text`;
// not those that the protocol has as its own parameters. Errors: invalid_request, as
// parse_protocol; `*wrong` then is the value that was refused, or none where the text itself is
// bad. The parser of the new text checks the values.
Result<std::string> with_meter_values(std::string_view text, const std::string& name,
                                      ParameterValues& values, MeterValue* wrong = nullptr);

}  // namespace lcrig
