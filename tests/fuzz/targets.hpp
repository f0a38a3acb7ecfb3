// SPDX-License-Identifier: Apache-2.0
// The fuzz targets, one function per reader of bytes from outside. They run under libFuzzer
// (tools/check/fuzz), and in unit_fuzz_tests over the seeds and every crash found so far.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "base/text.hpp"

namespace lcrig::fuzz {

// Each reads `input` with the real code and throws std::logic_error if a property does not hold.
void read_lcr_codec(std::string_view input);
void read_frame_link(std::string_view input);
void read_control(std::string_view input);
void read_protocol(std::string_view input);
void read_specimen(std::string_view input);
void read_config(std::string_view input);
void read_wire_log(std::string_view input);

struct Target {
  std::string_view name;  // folder of its corpus
  void (*read)(std::string_view input);
  std::string_view more;  // another folder of inputs, with subfolders; may be empty
};
inline constexpr std::array<Target, 7> kTargets{{
    {"control", read_control, ""},
    {"protocol", read_protocol, "tests/corpus/protocol"},
    {"wire_log", read_wire_log, "tests/replay"},
    {"lcr_codec", read_lcr_codec, ""},
    {"frame_link", read_frame_link, ""},
    {"config", read_config, "tests/corpus/config"},
    {"specimen", read_specimen, "model/library"},
}};

void require(bool holds, const std::string& what);
// A refusal must have a text of one readable line that is harmless on a terminal.
void require_good_message(const Error& error);
inline void require_good_message(std::string_view what) {
  require_good_message(Error(Errc::invalid_request, std::string(what)));
}

}  // namespace lcrig::fuzz
