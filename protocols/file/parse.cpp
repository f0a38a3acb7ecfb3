// SPDX-License-Identifier: Apache-2.0
#include "protocols/file/parse.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/key_words.hpp"
#include "base/near_word.hpp"
#include "base/text.hpp"
#include "protocols/expand.hpp"
#include "protocols/file/parse_steps.hpp"
#include "protocols/file/step_reader.hpp"

namespace lcrig {

namespace {

Parameter parse_parameter(const JsonReader& r) {
  Parameter p;
  const std::string name = r.last_key();
  const KeyParts key = split_key(name);
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  if (name.empty() || name.size() > 64 || !std::ranges::all_of(name, good)) {
    r.refuse_key(fmt::format("the name \"{}\", expected letters, digits and _", printable(name)));
  }
  if (const auto unit = name_unit_mistake(name)) r.refuse_key(*unit);
  p.to_si = key.to_si();
  p.min = r.number("min");
  p.max = r.number("max");
  p.default_value = r.number("default");
  p.description = r.optional_string("description").value_or("");
  const auto whole = [](double v) { return v == std::floor(v); };
  const bool all_whole = whole(p.min) && whole(p.max) && whole(p.default_value);
  p.integer = r.optional_boolean("integer").value_or(!key.unit && all_whole);
  if (p.integer && !all_whole) {
    r.refuse("a fraction in default, min or max, expected whole numbers for an integer");
  }
  if (p.min > p.max) r.refuse(fmt::format("min {} above max {}", p.min, p.max));
  if (r.sound() && (p.default_value < p.min || p.default_value > p.max)) {
    r.at("default").refuse(
        fmt::format("{}, expected from {} to {} (min, max)", p.default_value, p.min, p.max));
  }
  r.no_other_keys();
  return p;
}

void parse_parameters(const JsonReader& top, Protocol& out, Scope& scope) {
  const auto all = top.find("parameters");
  if (!all) {
    // The parameters may stand under a mistyped key.
    if (nearest_word("parameters", top.keys())) scope.set_names_doubtful(true);
    return;
  }
  if (!all->is_object()) scope.set_names_doubtful(true);
  for (const JsonReader& r : all->members()) {
    const Parameter p = parse_parameter(r);
    ScopeEntry entry;
    entry.dimension = split_key(r.last_key()).dimension();
    entry.min = p.min * p.to_si;
    entry.max = p.max * p.to_si;
    entry.integer = p.integer;
    entry.bounded = r.sound();
    entry.unit_known = !find_unknown_unit(r.last_key());
    scope.add(r.last_key(), entry);
    out.parameters[r.last_key()] = p;
  }
}

// A window such as "force_N": [-0.2, 1.5].
std::optional<std::pair<Number, Number>> parse_window(const JsonReader& limits,
                                                      std::string_view stem, Dimension d,
                                                      const Scope& scope) {
  const auto field = limits.find_quantity(stem, d);
  if (!field) return std::nullopt;
  const auto ends = field->value.items(2, 2);
  if (ends.size() != 2) return std::nullopt;
  const double unit = field->unit.to_si;
  std::pair<Number, Number> out(scope.read(ends[0], d, unit, kAnyNumber),
                                scope.read(ends[1], d, unit, kAnyNumber));
  // If parameters move the ends, the plan compares them.
  const bool literal = out.first.name.empty() && out.second.name.empty();
  if (literal && out.first.value >= out.second.value) {
    field->value.refuse(fmt::format("from {:.6g} to {:.6g}, expected the lower limit first",
                                    out.first.value / unit, out.second.value / unit));
  }
  return out;
}

Limits parse_limits(const JsonReader& r, const Scope& scope) {
  Limits out;
  if (const auto force = parse_window(r, "force", Dimension::force, scope)) {
    std::tie(out.force_min, out.force_max) = *force;
  } else if (std::ranges::any_of(r.keys(), [](const auto& k) { return k.starts_with("force"); })) {
    static_cast<void>(r.quantity("force", Dimension::force));  // refuses the key with the right
                                                               // words
  }
  if (const auto travel = parse_window(r, "travel", Dimension::length, scope)) {
    std::tie(out.travel_min, out.travel_max) = *travel;
  }
  if (const auto gap = parse_window(r, "gap", Dimension::length, scope)) {
    std::tie(out.gap_min, out.gap_max) = *gap;
  }
  out.speed_max = scope.optional(r, "speed", Dimension::speed, kPositive);
  r.no_other_keys();
  return out;
}

void parse_aperture(const JsonReader& r, Sampling& out) {
  using Choice = std::optional<Aperture>;
  std::vector<std::pair<std::string_view, Choice>> words;
  for (const auto& [text, aperture] : word_table<Aperture>()) words.emplace_back(text, aperture);
  words.emplace_back(kAutoAperture, std::nullopt);
  const auto chosen = r.word<Choice>("aperture", words);
  out.aperture_auto = !chosen;
  out.lcr.aperture = chosen.value_or(Aperture::fast);
}

void parse_lcr(const JsonReader& r, Sampling& out) {
  out.lcr.function = r.word<LcrFunction>("function");
  out.lcr.frequency =
      Frequency::from_si(r.quantity("frequency", Dimension::frequency, kFrequencyRange));
  out.lcr.level = Voltage::from_si(r.quantity("level", Dimension::voltage, kLevelRange));
  parse_aperture(r, out);
  out.lcr.average = static_cast<int>(r.optional_integer("average", 1, kAverageMax).value_or(1));
  if (const auto bias = r.optional_quantity("bias", Dimension::voltage, kBiasRange)) {
    out.lcr.bias = Voltage::from_si(*bias);
  }
  if (r.has("trigger")) out.lcr.trigger = r.word<LcrTrigger>("trigger");
  if (const auto pause =
          r.optional_quantity("poll_interval", Dimension::time, Range{0.001, 3600})) {
    out.lcr.poll_interval = from_seconds(*pause);
    if (out.lcr.trigger != LcrTrigger::internal) {
      r.refuse("poll_interval without \"trigger\": \"internal\", expected both or none");
    }
  }
  out.lcr_continuous = r.optional_boolean("continuous").value_or(true);
  r.no_other_keys();
}

Sampling parse_sample(const JsonReader& r) {
  Sampling out;
  parse_lcr(r.object("lcr"), out);
  if (const auto frame = r.find("frame")) {
    out.frame_rate_Hz = frame->quantity("rate", Dimension::frequency, Range{0.1, 100'000});
    frame->no_other_keys();
  }
  r.no_other_keys();
  return out;
}

void parse_steps(const JsonReader& top, const Scope& scope, Protocol& out) {
  StepsParser parser(scope);
  const JsonReader steps = top.at("steps");
  out.steps = parser.parse(steps, 1);
  const JsonReader finally_steps = top.at("finally");
  out.finally_steps = parser.parse(finally_steps, 0);
  // Mistakes in the steps may hide steps that the checks below need.
  if (!steps.sound() || !finally_steps.sound()) return;
  if (asks_person(out.finally_steps)) {
    finally_steps.refuse(
        "a step that asks, expected none: `finally` unloads the specimen when nobody may be there");
  }
  if (has_safe_point(out.finally_steps)) {
    finally_steps.refuse("a safe point, expected none: `finally` runs to its end");
  }
  const bool loads = commands_frame(out) || places_weights(out.steps);
  if (loads && !out.limits.force_min) {
    top.at("limits").refuse("no force window, expected force_N in a protocol that loads");
  }
  if (!moves_frame(out)) return;
  if (out.finally_steps.empty()) {
    finally_steps.refuse("no steps, expected at least one in a protocol with motion");
  }
  if (!out.limits.travel_min && !out.limits.gap_min) {
    top.at("limits").refuse(
        "no travel window, expected travel_mm or gap_mm in a protocol with motion");
  }
}

void parse_top(const JsonReader& top, Protocol& out) {
  top.expect_format("load-protocol/1");
  const JsonReader name = top.at("name");
  out.name = read_name(name);
  if (out.name.starts_with('-')) {
    name.refuse(fmt::format(
        "\"{}\", expected another first character: commands take it for an option", out.name));
  }
  out.title = top.optional_string("title").value_or("");
  out.description = top.optional_string("description").value_or("");
  Scope scope;
  parse_parameters(top, out, scope);
  if (top.has("pressure_on")) out.pressure_on = top.word<PressureOn>("pressure_on");
  out.limits = parse_limits(top.object("limits"), scope);
  out.sample = parse_sample(top.object("sample"));
  if (top.has("on_loss")) out.on_loss = top.word<OnLoss>("on_loss");
  if (const auto t = top.optional_quantity("on_loss_timeout", Dimension::time, Range{1, 604800})) {
    out.on_loss_timeout = from_seconds(*t);
  }
  if (const auto t = top.optional_quantity("finally_timeout", Dimension::time, Range{1, 86400})) {
    out.finally_timeout = from_seconds(*t);
  }
  parse_steps(top, scope, out);
  top.no_other_keys();
}

}  // namespace

Result<Protocol> parse_protocol(std::string_view text, const std::string& name) {
  const auto document = JsonDocument::parse(text, name);
  if (!document) return fail(document.error());
  const JsonReader top(*document);
  Protocol out;
  parse_top(top, out);
  if (auto r = top.result(); !r) return fail(r.error());
  out.file = name;
  out.text = std::string(text);
  return out;
}

Result<Protocol> load_protocol(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return fail(text.error());
  return parse_protocol(*text, path);
}

}  // namespace lcrig
