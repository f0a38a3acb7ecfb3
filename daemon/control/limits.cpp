// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace lcrig {

using nlohmann::json;

namespace {

// Counts; every event that returns false ends the parse.
class Counter final : public nlohmann::json_sax<json> {
 public:
  std::optional<std::string> why;

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool start_object(std::size_t) override { return open(); }
  bool start_array(std::size_t) override { return open(); }
  bool key(string_t&) override { return true; }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  // Whoever parses it says what is wrong.
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return false;
  }

 private:
  bool value() {
    if (++values_ <= kControlValuesMax) return true;
    why = fmt::format("more than {} values in one message", kControlValuesMax);
    return false;
  }
  bool open() {
    if (++depth_ > kControlDepthMax) {
      why = fmt::format("more than {} objects and arrays inside each other", kControlDepthMax);
    }
    return !why && value();
  }
  bool close() {
    --depth_;
    return true;
  }

  std::size_t depth_ = 0, values_ = 0;
};

constexpr std::size_t kLongLine = 4096;
constexpr double kBurst = 1 << 20U;  // bytes: one line of the largest size

}  // namespace

std::optional<std::string> refuse_structure(std::string_view line) {
  Counter counter;
  json::sax_parse(line, &counter);
  return counter.why;
}

Duration ControlBudget::charge(std::size_t bytes, MonoTime now) {
  if (bytes <= kLongLine) return {};
  tokens_ = std::min(kBurst, tokens_ + to_seconds(now - refilled_) * bytes_per_s_);
  refilled_ = now;
  tokens_ -= static_cast<double>(bytes);
  return tokens_ >= 0 ? Duration() : from_seconds(-tokens_ / bytes_per_s_);
}

double ControlBudget::share() const {
  constexpr double kFullShares = 8;
  return std::min(1.0, kFullShares / static_cast<double>(std::max<std::size_t>(clients_, 1)));
}

bool ControlBudget::take_call(std::size_t bytes) {
  if (call_bytes_ + bytes > max_call_bytes_) return false;
  call_bytes_ += bytes;
  return true;
}

}  // namespace lcrig
