// SPDX-License-Identifier: Apache-2.0
// The wire log: everything that went over a port, as text (docs/wire-log.md). Written by
// RecordingTransport; the driver tests play such logs (tests/support/replay_transport.hpp).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.hpp"

namespace lcrig {

struct WireLogHeader {
  std::string instrument, firmware, date, conditions;
};

// The first line of a log, and the words of its header.
inline constexpr std::string_view kWireLogFormat = "wire-log/1";
inline constexpr std::array<std::pair<std::string_view, std::string WireLogHeader::*>, 4>
    kWireLogFields{{
        {"instrument", &WireLogHeader::instrument},
        {"firmware", &WireLogHeader::firmware},
        {"date", &WireLogHeader::date},
        {"conditions", &WireLogHeader::conditions},
    }};

std::string format_wire_header(const WireLogHeader& header);
std::string format_wire_entry(std::int64_t t_ns, bool to_instrument, std::string_view bytes);
// Puts quotation marks around the bytes. Printable ASCII stays, the rest becomes \n \r \t \\ \"
// \xNN.
std::string quote_bytes(std::string_view bytes);

}  // namespace lcrig
