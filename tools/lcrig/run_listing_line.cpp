// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/run_listing_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

namespace {

// Most names are plain; any other text takes the way of all JSON.
std::string in_quotes(std::string_view text) {
  constexpr auto is_plain = [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
  if (!std::ranges::all_of(text, is_plain)) return json_line(std::string(text));
  return fmt::format("\"{}\"", text);
}

std::string joined_tags(const std::vector<std::string>& tags) {
  std::string out;
  for (const auto& tag : tags) out += (out.empty() ? "" : ",") + in_quotes(tag);
  return out;
}

}  // namespace

std::string run_listing_line(const RunListing& r) {
  std::string out;
  const auto add = std::back_inserter(out);
  const auto ended = r.ended_unix_ns ? in_quotes(format_utc(*r.ended_unix_ns)) : "null";
  const auto status = r.exit_status ? in_quotes(to_string(*r.exit_status)) : "null";
  fmt::format_to(add, R"({{"ended":{},"events":{},"exit_status":{},"frame_samples":{},)", ended,
                 r.events, status, r.frame_samples);
  fmt::format_to(add, R"("goes_on":{},"lcr_readings":{},"levels":{},"operator":{},)", r.goes_on,
                 r.lcr_readings, r.levels, in_quotes(r.operator_name));
  fmt::format_to(add, R"("protocol":{},"reason":{},"run":{},"simulated":{},)",
                 in_quotes(r.protocol_name), in_quotes(r.reason), r.run, r.simulated);
  fmt::format_to(add, R"("specimen":{},"started":{},"tags":[{}],"uuid":{}}})",
                 in_quotes(r.specimen_name), in_quotes(format_utc(r.started_unix_ns)),
                 joined_tags(r.tags), r.uuid.empty() ? "null" : in_quotes(r.uuid));
  return out;
}

}  // namespace lcrig::cli
