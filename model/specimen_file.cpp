// SPDX-License-Identifier: Apache-2.0
#include "model/specimen_file.hpp"

#include <utility>

#include "base/name_rule.hpp"
#include "base/near_word.hpp"
#include "base/strict_json.hpp"

namespace lcrig {
namespace {

constexpr Range kPermittivity{1, 1e6, false};
constexpr Range kModulus{1e-3, 1e15, false};  // Pa
constexpr Range kPoisson{0, 0.5, false};
constexpr Range kFraction{0, 10, true};
constexpr Range kSize{0, 10, true};  // m

Material read_material(const JsonReader& reader) {
  Material m;
  m.name = reader.last_key();
  m.relative_permittivity = reader.number("relative_permittivity", kPermittivity);
  m.rigid = reader.optional_boolean("rigid").value_or(false);
  const auto youngs = reader.optional_quantity("youngs_modulus", Dimension::pressure, kModulus);
  const auto poisson = reader.optional_number("poisson_ratio", kPoisson);
  m.given_shear_modulus_Pa =
      reader.optional_quantity("shear_modulus", Dimension::pressure, kModulus);
  reader.no_other_keys();
  if (!m.rigid && (!youngs || !poisson)) {
    reader.refuse("has neither `rigid`: true nor both of `youngs_modulus_kPa` and `poisson_ratio`");
  }
  m.youngs_modulus_Pa = youngs.value_or(0);
  m.poisson_ratio = poisson.value_or(0);
  return m;
}

Layer read_layer(const JsonReader& reader, const Specimen& specimen, bool materials_read) {
  Layer layer;
  const JsonReader field = reader.at("material");
  const std::string name = field.nonempty_string();
  layer.thickness_m = reader.quantity("thickness", Dimension::length, kSize);
  reader.no_other_keys();
  std::vector<std::string> known;
  for (const auto& material : specimen.materials) {
    if (material.name == name) {
      layer.material = known.size();
      return layer;
    }
    known.push_back(material.name);
  }
  if (!materials_read) return layer;
  std::string all;
  for (const auto& one : known) all += (all.empty() ? "" : ", ") + one;
  field.refuse("unknown material \"" + name + "\"" + or_comma(did_you_mean(name, known)) +
               " expected one of `materials`: " + (all.empty() ? "there is none" : all));
  return layer;
}

void read_options(const JsonReader& reader, Specimen& s) {
  if (const auto gap = reader.find("contact_gap")) {
    s.contact_gap = ContactGap{gap->quantity("height", Dimension::length, kSize),
                               gap->quantity("half_pressure", Dimension::pressure, kModulus)};
    gap->no_other_keys();
  }
  if (const auto creep = reader.find("creep")) {
    s.creep = Creep{creep->number("fraction", kFraction),
                    creep->quantity("time", Dimension::time, kPositive)};
    creep->no_other_keys();
  }
}

Specimen read_specimen(const JsonReader& reader) {
  Specimen s;
  reader.expect_format("specimen/1");
  s.name = reader.at("name").nonempty_string();
  s.disc_diameter_m = reader.quantity("disc_diameter", Dimension::length, kSize);
  s.faces = reader.word<Faces>("faces");
  if (const auto top = reader.find("top")) s.top = top->word<Top>();
  const JsonReader materials = reader.object("materials");
  for (const auto& material : materials.members()) {
    s.materials.push_back(read_material(material));
  }
  for (const auto& item : reader.at("capacitors").items(1)) {
    Capacitor capacitor;
    for (const auto& layer : item.at("layers").items(1)) {
      capacitor.layers.push_back(read_layer(layer, s, materials.is_object()));
    }
    item.no_other_keys();
    s.capacitors.push_back(std::move(capacitor));
  }
  read_options(reader, s);
  reader.no_other_keys();
  return s;
}

Result<Specimen> from_document(const JsonDocument& document, bool brought_in) {
  const JsonReader reader(document);
  Specimen specimen = read_specimen(reader);
  if (const auto why = brought_in && reader.sound() ? why_no_name(specimen.name) : std::nullopt) {
    reader.at("name").refuse(*why);
  }
  if (auto ok = reader.result(); !ok) return fail(ok.error());
  if (auto ok = check_specimen(specimen); !ok) {
    return fail(ok.error().code, "{}: {}", document.name(), ok.error().what);
  }
  return specimen;
}

}  // namespace

Result<Specimen> parse_specimen(std::string_view text, const std::string& source) {
  auto document = JsonDocument::parse(text, source);
  if (!document) return fail(document.error());
  return from_document(*document, false);
}

Result<Specimen> accept_specimen(std::string_view text, const std::string& source) {
  auto document = JsonDocument::parse(text, source);
  if (!document) return fail(document.error());
  return from_document(*document, true);
}

Result<Specimen> load_specimen(const std::string& path) {
  auto document = load_json(path);
  if (!document) return fail(document.error());
  return from_document(*document, true);
}

}  // namespace lcrig
