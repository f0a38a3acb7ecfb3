// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/model_options.hpp"

#include <fmt/format.h>

#include <string>

#include "base/number.hpp"
#include "model/specimen_file.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/library_path.hpp"

namespace lcrig::cli {

namespace {
constexpr double kLargestProbe_mm = 1e4;  // as the largest disc of a specimen file
}

void ModelOptions::declare_specimen(ArgumentList& list) {
  list.option("-s,--specimen", specimen_, kSpecimenWord,
              "What is pressed: a name or a specimen file", true);
  list.one_of("--faces", faces_, all_words<Faces>(), "Other faces than the specimen's");
  list.one_of("--top", top_, all_words<Top>(), "Other top than the specimen's");
  list.number("--probe-diameter-mm", probe_mm_, "D", kProbeHelp);
}

void ModelOptions::declare_level(ArgumentList& list) {
  auto levels = all_words<Level>();
  levels.insert(levels.begin(), "auto");
  list.one_of("--level", level_, levels,
              "Level of the model (default: the cheapest within the tolerance)");
  list.one_of("--pressure-kind", kind_, all_words<PressureKind>(),
              "Force over the reference or the current area");
  list.one_of("--form", form_, all_words<EnergyForm>(), "Strain energy (hyperelastic)");
  list.one_of("--lateral", lateral_, all_words<Lateral>(), "Sides of a layer (hyperelastic)");
  list.one_of("--area", area_, all_words<ElectrodeArea>(), "Electrode area (FEM levels)");
  list.one_of("--mesh", mesh_, {"0", "1", "2", "3"}, "Refinement, 0 coarse to 3 (FEM levels)");
  list.flag("--fringe", fringe_, "Add the field outside the gap (Love)");
}

Outcome<Specimen> ModelOptions::specimen(const Context& context) const {
  auto path = context.db_path();
  if (!path) return path.error();
  auto text = find_specimen_text(context, *path, specimen_);
  if (!text) return text.error();
  auto specimen = parse_specimen(text->text, text->name);
  if (!specimen) return Failure(specimen.error());
  if (!faces_.empty()) specimen->faces = parse_word<Faces>(faces_).value_or(specimen->faces);
  if (!top_.empty()) specimen->top = parse_word<Top>(top_).value_or(specimen->top);
  return *specimen;
}

Outcome<PressureArea> over_probe(const std::optional<double>& probe_mm, const Specimen& specimen) {
  PressureArea out;
  put_disc(specimen, out);
  if (!probe_mm) {
    out.on = PressureOn::disc;
    return out;
  }
  if (!(*probe_mm > 0 && *probe_mm <= kLargestProbe_mm)) {
    return Failure(kUsage,
                   fmt::format("--probe-diameter-mm {:g}: expected above 0, up to {:g}", *probe_mm,
                               kLargestProbe_mm),
                   "give the diameter of the probe tip, such as 4");
  }
  out.probe_diameter_m = *probe_mm * 1e-3;
  if (auto whole = require_whole_disc(out); !whole) {
    return Failure(whole.error(), "leave --probe-diameter-mm out for pressures over the disc");
  }
  return out;
}

std::string pressure_line(const PressureArea& pressure) {
  if (auto words = pressure.words(); !words.empty()) return words;
  const double disc_mm = pressure.disc_diameter_m.value_or(0) * 1e3;
  if (pressure.on == PressureOn::probe) {
    return fmt::format(
        "pressure is force over the probe of {:.6g} mm, which covers the disc of {:.6g} mm",
        pressure.probe_diameter_m.value_or(0) * 1e3, disc_mm);
  }
  return fmt::format(
      "pressure is force over the disc of {:.6g} mm ({:.4g} mm2); --probe-diameter-mm D states it "
      "over a probe",
      disc_mm, pressure.disc_area_m2().value_or(0) * 1e6);
}

Outcome<PressureArea> ModelOptions::pressure(const Specimen& specimen) const {
  return over_probe(probe_mm_, specimen);
}

std::string ModelOptions::ladder_command(const Context& context, Pressure pressure) const {
  Words words{"model", "ladder", "--specimen", specimen_};
  add_option(words, "--faces", faces_);
  add_option(words, "--top", top_);
  if (probe_mm_) add_option(words, "--probe-diameter-mm", fmt::format("{:g}", *probe_mm_));
  add_option(words, "--pressure-kPa", fmt::format("{:g}", pressure.si() / 1e3));
  return next_command(context.global, words);
}

Outcome<std::optional<LevelSettings>> ModelOptions::settings() const {
  LevelSettings settings;
  settings.form = parse_word<EnergyForm>(form_).value_or(settings.form);
  settings.lateral = parse_word<Lateral>(lateral_).value_or(settings.lateral);
  settings.pressure_kind = parse_word<PressureKind>(kind_).value_or(settings.pressure_kind);
  settings.electrode_area = parse_word<ElectrodeArea>(area_).value_or(settings.electrode_area);
  settings.mesh.refinement = mesh_.front() - '0';
  settings.fringe = fringe_;
  if (const auto level = parse_word<Level>(level_)) {
    settings.level = *level;
    return settings;
  }
  if (settings != LevelSettings()) {
    return Failure(kUsage,
                   "--form, --pressure-kind, --lateral, --area, --mesh and --fringe belong to a "
                   "--level",
                   "lcrig model curve --help");
  }
  return std::optional<LevelSettings>();
}

Outcome<double> parse_number(const char* option, const std::string& text) {
  if (const auto value = number_from<double>(text)) return *value;
  const auto comma = comma_words(text);
  return Failure(
      kUsage,
      fmt::format("{} \"{}\": {}", option, text, comma.empty() ? "expected a number" : comma),
      "give a number; its decimals stand behind a point");
}

}  // namespace lcrig::cli
