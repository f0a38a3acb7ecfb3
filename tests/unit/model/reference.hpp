// SPDX-License-Identifier: Apache-2.0
// Reference tables that lie beside the source tree. Tests are skipped with a message where these
// are missing. Used by the tests of the model.
#pragma once

#include <gtest/gtest.h>

#include <charconv>
#include <fstream>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "model/specimen_file.hpp"

namespace lcrig {

struct ReferenceRow {
  std::vector<std::string> cells;
  const std::string& operator[](std::size_t i) const { return cells.at(i); }
  double number(std::size_t i) const {
    double value = 0;
    const auto& text = cells.at(i);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    EXPECT_TRUE(error == std::errc() && end == text.data() + text.size()) << text;
    return value;
  }
};

// Rows below the header of a CSV file; empty when the file is not there.
inline std::vector<ReferenceRow> read_reference(const std::string& name) {
  std::ifstream file("../shared/reference/" + name);
  std::vector<ReferenceRow> rows;
  std::string line;
  for (bool header = true; std::getline(file, line); header = false) {
    ReferenceRow row;
    row.cells.emplace_back();
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') {
        quoted = !quoted;
      } else if (c == ',' && !quoted) {
        row.cells.emplace_back();
      } else if (c != '\r') {
        row.cells.back() += c;
      }
    }
    if (!header) rows.push_back(row);
  }
  return rows;
}

#define LCRIG_NEED_REFERENCE(rows, name)  \
  const auto rows = read_reference(name); \
  if (rows.empty()) GTEST_SKIP() << "no ../shared/reference/" << (name) << " beside the source"

inline Specimen shipped(std::string_view name) {
  for (const auto& s : shipped_specimens()) {
    if (s.name == name) {
      auto specimen = parse_specimen(s.text, std::string(name));
      if (!specimen) throw std::runtime_error(specimen.error().what);
      return *specimen;
    }
  }
  throw std::runtime_error("no such shipped specimen");
}

// Capacitors of soft layers of one material, with these thicknesses.
inline Specimen soft_stack(const std::vector<double>& thickness_m) {
  Specimen s = shipped("paper-1");
  s.name = "soft";
  s.capacitors.clear();
  for (const double t : thickness_m) s.capacitors.push_back({{{0, t}}});
  return s;
}

// N capacitors of PDMS below elastic kapton, as in the references (E follows from mu = 42 kPa).
inline Specimen laminate(std::size_t n) {
  Specimen s = shipped("paper-1");
  s.faces = Faces::bonded_laminate;
  for (Material& m : s.materials) {
    m.youngs_modulus_Pa = m.rigid ? 2.5e9 : 2 * 42e3 * 1.49;
    m.poisson_ratio = m.rigid ? 0.34 : 0.49;
    m.rigid = false;
  }
  s.capacitors.assign(n, s.capacitors.front());
  return s;
}

// The laminate turned over: PDMS on top, with nothing above it.
inline Specimen open_laminate(std::size_t n) {
  Specimen s = laminate(n);
  s.faces = Faces::bonded_base;
  for (Capacitor& c : s.capacitors) std::swap(c.layers.at(0), c.layers.at(1));
  return s;
}

// N layers of 100 um PDMS on a bonded base (E follows from mu = 42 kPa).
inline Specimen soft_block(std::size_t n) {
  Specimen s = soft_stack(std::vector<double>(n, 100e-6));
  s.faces = Faces::bonded_base;
  for (Material& m : s.materials) m.youngs_modulus_Pa = 2 * 42e3 * 1.49;
  return s;
}

// A disc of radius 1 m and modulus 1 Pa between rigid plates to which it is bonded.
inline Specimen punch(double shape_factor, double nu) {
  Specimen s;
  s.name = "punch";
  s.disc_diameter_m = 2;
  s.faces = Faces::bonded_base;
  s.top = Top::bonded_plate;
  s.materials = {Material{"m", 1, false, 1.0, nu, {}}};
  s.capacitors = {{{{0, 1 / (2 * shape_factor)}}}};
  return s;
}

inline void expect_relative(double value, double expected, double tolerance,
                            const std::string& what = {}) {
  EXPECT_LE(std::abs(value - expected), tolerance * std::abs(expected))
      << what << ": " << value << " instead of " << expected << ", relative "
      << (value - expected) / expected;
}

}  // namespace lcrig
