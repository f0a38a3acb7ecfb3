// SPDX-License-Identifier: Apache-2.0
// The grammar of the simulated meter: headers in long and short form, parameters, read-backs.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/clock.hpp"
#include "base/text.hpp"
#include "drivers/lcr6100/sim.hpp"

namespace lcrig::lcr6100 {

enum class Reply { as_is, lower, frequency, volt, bias, number, delay, silent };

struct Lcr6100Sim::Parameter {
  std::string_view header;
  std::string_view words;  // accepted words, separated by blanks; nothing may follow one
  double min = 1, max = 0;  // min > max: words only
  std::string_view word;  // value at power-on; empty: `number` is
  double number = 0;
  Reply reply = Reply::as_is;
  bool restarts = false;  // a change starts a new conversion
};

namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 22> kShort{{
    {"APERTURE", "APER"}, {"COMPARATOR", "COMP"}, {"CORRECTION", "CORR"}, {"CURRENT", "CURR"},
    {"DISPLAY", "DISP"},  {"ERROR", "ERR"},       {"FETCH", "FETC"},      {"FREQUENCY", "FREQ"},
    {"FUNCTION", "FUNC"}, {"IMPEDANCE", "IMP"},   {"LEVEL", "LEV"},       {"MONITOR1", "MON1"},
    {"MONITOR2", "MON2"}, {"MONITOR", "MON"},     {"RANGE", "RANG"},      {"SHORT", "SHOR"},
    {"SOURCE", "SOUR"},   {"SRESIST", "SRES"},    {"STATE", "STAT"},      {"SYSTEM", "SYST"},
    {"TRIGGER", "TRIG"},  {"VOLTAGE", "VOLT"},
}};
constexpr std::string_view kFunctions =
    "Cs-Rs Cs-D Cp-Rp Cp-D Lp-Rp Lp-Q Ls-Rs Ls-Q Rs-Q Rp-Q R-X DCR Z-thr Z-thd Z-D Z-Q";
constexpr std::string_view kMonitors = "OFF Z D Q THR THD R X G B Y ABS PER VAC IAC";
constexpr std::string_view kPages = "MEAS ENLA BINM BCO LIST MSET CSET BSET LSET CAT SYST SINF";
constexpr std::array<std::string_view, 3> kApertureWords{"FAST", "MED", "SLOW"};

std::string upper(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](char c) {
    return static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  });
  return out;
}

// The word of the list that equals `text`, in the list's spelling.
std::optional<std::string_view> find_word(std::string_view list, std::string_view text) {
  const std::string wanted = upper(text);
  while (!list.empty()) {
    const auto end = std::min(list.find(' '), list.size());
    if (upper(list.substr(0, end)) == wanted) return list.substr(0, end);
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return std::nullopt;
}

// Suffix multipliers of the manual (p.101), then a unit.
double multiplier(std::string_view& suffix) {
  constexpr std::array<std::pair<std::string_view, double>, 11> kMultipliers{{
      {"EX", 1e18},
      {"PE", 1e15},
      {"MA", 1e6},
      {"T", 1e12},
      {"G", 1e9},
      {"K", 1e3},
      {"M", 1e-3},
      {"U", 1e-6},
      {"N", 1e-9},
      {"P", 1e-12},
      {"F", 1e-15},
  }};
  for (const auto& [text, factor] : kMultipliers) {
    if (!suffix.starts_with(text)) continue;
    suffix.remove_prefix(text.size());
    return factor;
  }
  return 1;
}

std::optional<double> parse_number(std::string_view argument) {
  const std::string text = upper(argument);
  std::string_view rest = text;
  if (rest.starts_with('+')) rest.remove_prefix(1);
  double number = 0;
  const auto r = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (r.ec != std::errc() || !std::isfinite(number)) return std::nullopt;
  std::string_view suffix = rest.substr(static_cast<std::size_t>(r.ptr - rest.data()));
  if (suffix != "HZ" && suffix != "V" && suffix != "S") number *= multiplier(suffix);
  const bool unit = suffix.empty() || suffix == "HZ" || suffix == "V" || suffix == "S";
  return unit ? std::optional(number) : std::nullopt;
}

std::string shown(Reply reply, const std::string& word, double number) {
  if (!word.empty()) return reply == Reply::lower ? lower_case(word) : word;
  switch (reply) {
    case Reply::frequency: return fmt::format("{:.6e}", number);
    case Reply::volt: return fmt::format("{:.3e}V", number);
    case Reply::bias: return fmt::format("{:+.2f}V", number);
    case Reply::delay: return fmt::format("{:.0f}ms", number * 1e3);
    default: return fmt::format("{:g}", number);
  }
}

}  // namespace

// Power-on values differ from those that a driver sets, so that tests notice a lost command.
const std::vector<Lcr6100Sim::Parameter>& Lcr6100Sim::parameters() {
  constexpr std::string_view kOnOff = "ON OFF";
  static const std::vector<Parameter> table{
      {"FREQ", "", 10, 100e3, "", 100, Reply::frequency, true},
      {"LEV:VOLT", "", 0.010, 2.0, "", 0.5, Reply::volt, true},
      {"FUNC", kFunctions, 1, 0, "Ls-Q", 0, Reply::as_is, true},
      {"TRIG:SOUR", "INT MAN EXT BUS", 1, 0, "INT", 0, Reply::as_is, true},
      {"FUNC:MON1", kMonitors, 1, 0, "Z", 0, Reply::lower, false},
      {"FUNC:MON2", kMonitors, 1, 0, "IAC", 0, Reply::lower, false},
      {"SYST:CODE", kOnOff, 1, 0, "OFF"},
      {"SYST:SHAK", kOnOff, 1, 0, "OFF"},
      {"SYST:RES", "FETCH AUTO", 1, 0, "FETCH"},
      {"SYST:KEYLOCK", kOnOff, 1, 0, "OFF"},
      {"FUNC:IMP:AUTO", kOnOff, 1, 0, "ON"},
      {"FUNC:IMP:RANG", "", 0, 8, "", 0, Reply::number, true},
      {"FUNC:DCR:RANG", "", 0, 8, "", 0, Reply::number, true},
      {"FUNC:RANG:AUTO", "AUTO HOLD NOM", 1, 0, "HOLD", 0, Reply::as_is, true},
      {"LEV:CURR", "", 100e-6, 20e-3, "", 100e-6, Reply::silent, false},
      {"LEV:SRES", "30 50 100", 1, 0, "50", 0, Reply::as_is, true},
      {"LEV:ALC", kOnOff, 1, 0, "ON", 0, Reply::as_is, true},
      {"BIAS", "OFF", -2.5, 2.5, "OFF", 0, Reply::bias, true},
      {"COMP:STAT", kOnOff, 1, 0, "ON"},
      {"CORR:OPEN:STAT", kOnOff, 1, 0, "OFF", 0, Reply::lower, true},
      {"CORR:SHOR:STAT", kOnOff, 1, 0, "OFF", 0, Reply::lower, true},
      {"DISP:PAGE", kPages, 1, 0, "SYST", 0, Reply::lower, false},
      {"TRIG:DLY", "", 0, 60, "", 0, Reply::delay, true},
      {"FILE:LOAD", "", 0, 99, "", 0, Reply::silent, false},
  };
  return table;
}

void Lcr6100Sim::reset() {
  values_.resize(parameters().size());
  for (std::size_t i = 0; i < values_.size(); ++i) {
    values_[i].word = parameters()[i].word;
    values_[i].number = parameters()[i].number;
    if (config_.corrected && parameters()[i].header.starts_with("CORR:")) values_[i].word = "ON";
  }
  aperture_ = 2;
  average_ = 1;
  before_.clear();
  note_settings();
}

SimSettings Lcr6100Sim::settings_now() const {
  SimSettings s;
  s.function = value("FUNC").word;
  s.range = value("FUNC:RANG:AUTO").word;
  s.frequency_Hz = value("FREQ").number;
  s.level_V = value("LEV:VOLT").number;
  if (value("BIAS").word.empty()) s.bias_V = value("BIAS").number;
  s.aperture = static_cast<std::size_t>(aperture_);
  s.average = average_;
  s.open_correction = value("CORR:OPEN:STAT").word == "ON";
  s.short_correction = value("CORR:SHOR:STAT").word == "ON";
  return s;
}

namespace {

constexpr double kMostAveraged = 256;

struct PanelEntry {
  std::string_view set, query;
};
constexpr std::array<PanelEntry, 8> kPanel{{{"FUNC", "FUNC"},
                                            {"FREQ", "FREQ"},
                                            {"LEV:VOLT", "LEV:VOLT"},
                                            {"APER", "APER:RATE"},
                                            {"APER", "APER:AVG"},
                                            {"FUNC:RANG:AUTO", "FUNC:RANG:AUTO"},
                                            {"BIAS", "BIAS"},
                                            {"CORR:OPEN:STAT", "CORR:OPEN:STAT"}}};

}  // namespace

const Lcr6100Sim::Parameter& Lcr6100Sim::parameter_of(PanelKey key) {
  return *std::ranges::find(parameters(), kPanel[static_cast<std::size_t>(key)].set,
                            &Parameter::header);
}

bool Lcr6100Sim::accepts(PanelKey key, std::string_view to) {
  const auto count = parse_number(to);
  if (key == PanelKey::aperture) {
    return std::ranges::find(kApertureWords, upper(to)) != kApertureWords.end();
  }
  if (key == PanelKey::average) {
    return count && *count >= 1 && *count <= kMostAveraged && *count == std::floor(*count);
  }
  const auto& p = parameter_of(key);
  return find_word(p.words, to) || (count && *count >= p.min && *count <= p.max);
}

std::string Lcr6100Sim::accepted_words(PanelKey key) {
  if (key == PanelKey::aperture) return fmt::format("{}", fmt::join(kApertureWords, ", "));
  if (key == PanelKey::average) return fmt::format("1 to {}", kMostAveraged);
  const auto& p = parameter_of(key);
  std::string out(p.words);
  for (std::size_t at = out.find(' '); at != std::string::npos; at = out.find(' ', at + 2)) {
    out.replace(at, 1, ", ");
  }
  if (p.min > p.max) return out;
  return fmt::format("{}{}{:g} to {:g}", out, out.empty() ? "" : ", or ", p.min, p.max);
}

bool Lcr6100Sim::turn(PanelKey key, std::string_view to) {
  const auto before = before_.find(key);
  const std::string wanted =
      to.empty() && before != before_.end() ? before->second : std::string(to);
  if (!accepts(key, wanted)) return false;
  const PanelEntry& entry = kPanel[static_cast<std::size_t>(key)];
  if (!to.empty()) before_[key] = *read(entry.query);
  set(std::string(entry.set), wanted);
  note_settings();
  return true;
}

const Lcr6100Sim::Value& Lcr6100Sim::value(std::string_view header) const {
  const auto it = std::ranges::find(parameters(), header, &Parameter::header);
  return values_.at(static_cast<std::size_t>(it - parameters().begin()));
}

// Turns a header into upper case and short form, relative to the message's path. Updates the path.
std::string Lcr6100Sim::resolve(std::string_view header) {
  std::string text = upper(header);
  if (text.starts_with('*')) return text;
  const bool query = text.ends_with('?');
  if (query) text.pop_back();
  std::string full = text.starts_with(':') ? "" : path_;
  std::string_view rest = text;
  if (rest.starts_with(':')) rest.remove_prefix(1);
  while (!rest.empty()) {
    const auto end = std::min(rest.find(':'), rest.size());
    std::string_view word = rest.substr(0, end);
    const auto it = std::ranges::find(kShort, word, &decltype(kShort)::value_type::first);
    if (it != kShort.end()) word = it->second;
    full += word;
    if (end < rest.size()) full += ':';
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  const auto colon = full.rfind(':');
  path_ = colon == full.npos ? "" : full.substr(0, colon + 1);
  if (full == "FUNC:IMP:TYPE" || full == "FUNC:IMP") full = "FUNC";
  if (query) full += '?';
  return full;
}

Task<> Lcr6100Sim::command(std::string_view text) {
  text = trimmed(text);
  const auto blank = std::min(text.find(' '), text.size());
  std::string header = resolve(text.substr(0, blank));
  const std::string_view argument = trimmed(text.substr(blank));
  if (header.empty()) co_return;
  if (header.back() == '?') {
    co_await ask(std::move(header));
    co_return;
  }
  error_ = "*E00";
  if (header == "*TRG" || header == "TRIG") {
    co_await trigger(header == "*TRG");
  } else if (header == "CORR:OPEN:LCR" || header == "CORR:SHOR:LCR") {
    co_await correct();
  } else if (header == "UNLOCK" || header == "LOCAL" || header == "DISP:LINE") {
    co_return;
  } else if (faults_.lose_sets > 0) {
    --faults_.lose_sets;
  } else if (hooks_.loses_set && hooks_.loses_set()) {
    co_return;
  } else if (set(header, argument)) {
    note_settings(faults_.late_settings_s);
  } else {
    fail_with("*E01");
  }
}

bool Lcr6100Sim::set(const std::string& header, std::string_view argument) {
  if (header == "APER") {
    assign_aperture(argument);
    return true;
  }
  const auto& table = parameters();
  const auto it = std::ranges::find(table, header, &Parameter::header);
  if (it == table.end()) return false;
  assign(*it, values_[static_cast<std::size_t>(it - table.begin())], argument);
  if (header == "SYST:RES" && error_ == "*E00") faults_.streaming = value(header).word == "AUTO";
  return true;
}

void Lcr6100Sim::assign(const Parameter& p, Value& value, std::string_view argument) {
  if (argument.empty()) return fail_with("*E03");
  Value wanted;
  const std::string word = upper(argument);
  const bool numeric = p.min <= p.max;
  if (const auto found = find_word(p.words, argument)) {
    wanted.word = *found;
  } else if (numeric && (word == "MIN" || word == "MAX")) {
    wanted.number = word == "MIN" ? p.min : p.max;
  } else if (const auto number = parse_number(argument);
             numeric && number && *number >= p.min && *number <= p.max) {
    wanted.number = *number;
  } else {
    return fail_with("*E02");
  }
  if (p.restarts) restart_grid();
  value = std::move(wanted);
}

void Lcr6100Sim::assign_aperture(std::string_view argument) {
  if (argument.empty()) return fail_with("*E03");
  const auto rate = std::ranges::find(kApertureWords, upper(argument));
  const auto count = parse_number(argument);
  const bool valid = count && *count >= 1 && *count <= 256 && *count == std::floor(*count);
  if (rate == kApertureWords.end() && !valid) return fail_with("*E02");
  restart_grid();
  faults_.slow_factor = 1;
  if (rate != kApertureWords.end()) {
    aperture_ = static_cast<int>(rate - kApertureWords.begin());
  } else {
    average_ = static_cast<int>(*count);
  }
}

std::optional<std::string> Lcr6100Sim::read(std::string_view header) const {
  const std::string rate(kApertureWords[static_cast<std::size_t>(aperture_)]);
  if (header == "*IDN") return config_.identity;
  if (header == "ERR") return error_;
  if (header == "APER") return fmt::format("{},{}", rate, average_);
  if (header == "APER:RATE") return rate;
  if (header == "APER:AVG") return std::to_string(average_);
  if (header == "LEV:MODE") return "volt";
  const auto it = std::ranges::find(parameters(), header, &Parameter::header);
  if (it == parameters().end()) return std::nullopt;
  const Value& v = value(header);
  return it->reply == Reply::silent ? std::string() : shown(it->reply, v.word, v.number);
}

// An unknown question is not answered. Its error code can be read with ERR?.
Task<> Lcr6100Sim::ask(std::string header) {
  header.pop_back();
  if (header.starts_with("FETC")) {
    const std::string_view what = std::string_view(header).substr(4);
    const bool monitor = what.starts_with(":MON");
    if (what.empty() || what == ":IMP" || what == ":MAIN" || monitor) {
      const std::string_view form = monitor || what.empty() ? what.substr(0, 4) : what;
      co_await fetch(form);
      co_return;
    }
  }
  auto text = read(header);
  if (header != "ERR") error_ = text ? "*E00" : "*E01";
  if (text && !text->empty()) co_await answer(std::move(*text));
}

}  // namespace lcrig::lcr6100
