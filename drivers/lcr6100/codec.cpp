// SPDX-License-Identifier: Apache-2.0
#include "drivers/lcr6100/codec.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "base/text.hpp"
#include "drivers/lcr6100/pace.hpp"
#include "drivers/lcr6100/words.hpp"

namespace lcrig::lcr6100 {

namespace {

constexpr double kOverload = 9.9e19;  // the meter sends 1e20

// Removes and returns the number at the beginning of `text`. Refuses "inf", "nan" and hex.
std::optional<double> take_number(std::string_view& text) {
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  const std::size_t first = digits.starts_with('-') ? 1 : 0;
  if (digits.size() <= first || !(is_digit(digits[first]) || digits[first] == '.')) {
    return std::nullopt;
  }
  if (text.starts_with('+') && first == 1) return std::nullopt;  // "+-1"
  double value = 0;
  const auto r = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (r.ec != std::errc()) return std::nullopt;
  text = digits.substr(static_cast<std::size_t>(r.ptr - digits.data()));
  return value;
}

// The only valid form is sign, one digit, point, decimals, 'e', sign, two digits. Anything else
// lost or gained a byte on the line. Returns the number of decimals, or 0 for an invalid form.
std::size_t output_decimals(std::string_view f) {
  if (f.size() < 8 || (f[0] != '+' && f[0] != '-') || !is_digit(f[1]) || f[2] != '.') return 0;
  const std::size_t e = f.size() - 4;
  if (f[e] != 'e' || (f[e + 1] != '+' && f[e + 1] != '-')) return 0;
  if (!is_digit(f[e + 2]) || !is_digit(f[e + 3])) return 0;
  const auto decimals = f.substr(3, e - 3);
  return std::ranges::all_of(decimals, is_digit) ? decimals.size() : 0;
}

bool is_status_word(std::string_view f) {
  const std::string_view w = trimmed(f);
  if (w == "OUT" || w == "OK" || w == "NG" || w == "AUX-OK" || w == "AUX-NG") return true;
  return w.starts_with("BIN") && w.size() > 3 && w.size() <= 5 &&
         std::ranges::all_of(w.substr(3), is_digit);
}

struct Fields {
  explicit Fields(std::string_view t) : text(t) {}
  std::string_view text;
  std::size_t at = 0;
  bool next(std::string_view& field) {
    if (at > text.size()) return false;
    const auto comma = std::min(text.find(',', at), text.size());
    field = text.substr(at, comma - at);
    at = comma + 1;
    return true;
  }
};

tl::unexpected<Error> garbled(std::string_view line) {
  return fail(Errc::garbled, "\"{}\" is not a reading", printable(line.substr(0, 120)));
}

void store(ReadingLine& out, int index, double value) {
  const bool overload = std::abs(value) >= kOverload;
  if (index == 0) {
    if (!overload) out.primary = value;
    if (overload) out.flags |= lcr_flag::kPrimaryOverload;
  } else if (index == 1) {
    if (!overload) out.secondary = value;
    if (overload) out.flags |= lcr_flag::kSecondaryOverload;
  }
}

}  // namespace

Result<ReadingLine> parse_reading(std::string_view line) {
  ReadingLine out;
  Fields fields(line);
  std::string_view field;
  std::size_t decimals = 0, values_end = 0;
  bool more = fields.next(field);
  for (; more && output_decimals(field) > 0; more = fields.next(field)) {
    if (out.numbers == 0) decimals = output_decimals(field);
    std::string_view rest = field;
    const auto value = take_number(rest);
    if (!value || !rest.empty() || output_decimals(field) != decimals || out.numbers == 4) {
      return garbled(line);
    }
    store(out, out.numbers++, *value);
    values_end = static_cast<std::size_t>(field.data() + field.size() - line.data());
  }
  if (out.numbers == 0) return garbled(line);
  out.values = line.substr(0, values_end);
  if (!more) return out;  // an answer to FETC:MAIN? has no words
  out.status = line.substr(values_end + 1);
  for (int words = 0; more; more = fields.next(field)) {
    if (!is_status_word(field) || ++words > 3) return garbled(line);
  }
  return out;
}

Result<Identity> parse_identity(std::string_view line) {
  std::array<std::string_view, 4> part;
  std::string_view rest = trimmed(line);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto comma = rest.find(',');
    if (comma == rest.npos || comma == 0) {
      return fail(Errc::garbled, "\"{}\" is not an identity (MODEL,FIRMWARE,SERIAL,MAKER)",
                  printable(line.substr(0, 120)));
    }
    part[i] = trimmed(rest.substr(0, comma));
    rest.remove_prefix(comma + 1);
  }
  part[3] = trimmed(rest);  // contains a comma: "Good Will Instrument Co., Ltd."
  Identity out;
  out.model = part[0];
  out.firmware = part[1];
  out.serial = part[2];
  out.maker = part[3];
  out.text = trimmed(line);
  out.simulated = out.serial.starts_with("SIM");  // our simulators use such serial numbers
  return out;
}

bool is_supported_model(std::string_view model) {
  return model.starts_with("LCR-6") || model.starts_with("LCR-76");
}

std::string format_number(double value) {
  return fmt::format("{:+.5e}", value);
}

std::string format_parameter(double value) {
  std::array<char, 32> text;
  const auto r = std::to_chars(text.data(), text.data() + text.size(), value);
  return std::string(text.data(), r.ptr);
}

std::optional<double> parse_with_unit(std::string_view text) {
  std::string_view rest = trimmed(text);
  const auto value = take_number(rest);
  rest = trimmed(rest);
  if (!value) return std::nullopt;
  if (rest.empty() || same_word(rest, "V") || same_word(rest, "Hz") || same_word(rest, "s")) {
    return value;
  }
  if (same_word(rest, "mV") || same_word(rest, "ms")) return *value * 1e-3;
  if (same_word(rest, "kHz") && std::isfinite(*value * 1e3)) return *value * 1e3;
  return std::nullopt;
}

bool is_out_of_range(const LcrSettings& s, double primary) {
  constexpr double kDisplayed_ohm = 99.9999e6;  // LCR reference 4.4
  if (s.function == LcrFunction::ZThr || s.function == LcrFunction::ZThd) return primary <= 0;
  if (s.function == LcrFunction::RX) return std::abs(primary) > kDisplayed_ohm;
  // Kb of LCR reference 4.2 for FAST, three times as much as in the coarser rows of a relative.
  const double omega = 2 * std::numbers::pi * s.frequency.si();
  const double low = s.frequency.si() < 100 ? 1 + std::sqrt(100 / s.frequency.si()) : 1;
  const double error_F = 6e-9 * (1 + 0.1 / s.level.si()) * low / omega;
  return primary == 0 || primary < -error_F;
}

LcrCapabilities capabilities() {
  LcrCapabilities c;
  c.functions = {LcrFunction::CsRs, LcrFunction::CsD,  LcrFunction::CpRp, LcrFunction::CpD,
                 LcrFunction::RX,   LcrFunction::ZThr, LcrFunction::ZThd};
  c.frequency_min = Frequency::from_si(10);
  c.frequency_max = Frequency::from_si(100e3);
  c.level_min = Voltage::from_si(0.010);
  c.level_max = Voltage::from_si(2.0);
  c.bias_min = Voltage::from_si(-2.5);
  c.bias_max = Voltage::from_si(2.5);
  c.average_max = 256;
  // The time for FAST is from logs of a real LCR-6100, SLOW from 120-fold averaging on an LCR-6300,
  // and MED is estimated.
  c.conversion[0] = std::chrono::milliseconds(65);
  c.conversion[1] = std::chrono::milliseconds(120);
  c.conversion[2] = std::chrono::milliseconds(380);
  // Users of the meter wait 0.2 to 1 s after a change of function, frequency or aperture (LCR
  // reference 6). No source gives a time for the others.
  c.settling = std::chrono::seconds(1);
  // Question and answer take 4 ms on the line. Aperture and average share one.
  c.read_back = 12 * std::chrono::milliseconds(4);
  c.found_later = Pace::kLater;
  c.found_earlier = Pace::kEarlier;
  return c;
}

}  // namespace lcrig::lcr6100
