// SPDX-License-Identifier: Apache-2.0
// Where the travel and the force of a frame can be, given what it was ordered: two corridors, pure
// functions of the state of the rig. Each edge is a sum of named terms. A sample outside
// contradicts the order, the frame or the cell. Used by the checks, by permits, and by the report.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "protocols/rig/rig_state.hpp"

namespace lcrig {

struct Term {
  std::string_view name;
  double value = 0;
};

// One edge of a corridor, in the unit of the corridor.
class Edge {
 public:
  explicit Edge(std::string_view name) : name_(name) {}
  Edge& add(std::string_view term, double value) {
    terms_.at(count_++) = {term, value};
    sum_ += value;
    return *this;
  }
  std::string_view name() const { return name_; }
  double value() const { return sum_; }
  std::span<const Term> terms() const { return std::span(terms_).first(count_); }

 private:
  std::string_view name_;
  std::array<Term, 8> terms_;
  std::size_t count_ = 0;
  double sum_ = 0;
};

// Absent: nothing bounds this side.
struct Corridor {
  std::optional<Edge> lower, upper;
};

// Of the travel, m. While the frame moves: not against the order, and not faster than ordered from
// where it reported to stand. While it stands: where it stood.
Corridor travel_corridor(const RigState& rig, MonoTime t);

// Of the force that the cell shows at this travel, N. While the frame approaches, the lower edge is
// the highest of those below; on a retreat the upper edge counts. A force that is not valid bounds
// nothing.
Corridor force_corridor(const RigState& rig, MonoTime t, std::optional<double> travel_m);

// The edges of the travel while the frame moves: against its order, and ahead of it.
std::optional<Edge> edge_behind(const RigState& rig);
std::optional<Edge> edge_ahead(const RigState& rig, MonoTime t);

// The lower edges of an approach. From the force at the start of the motion; from the largest force
// of the motion; from the depth in a contact whose least stiffness is known, since the motion
// started, and since the largest force.
std::optional<Edge> edge_from_start(const RigState& rig, MonoTime t);
std::optional<Edge> edge_from_peak(const RigState& rig, MonoTime t);
std::optional<Edge> edge_in_contact(const RigState& rig, MonoTime t, double travel_m);
// The upper edge of a retreat.
std::optional<Edge> edge_of_retreat(const RigState& rig, MonoTime t);

// Whether this travel certainly lies in the contact, from where the force has to rise.
bool is_in_contact(const RigState& rig, MonoTime t, double travel_m);

// Whether nothing can press at this travel: well above a contact whose least stiffness is known.
bool is_clear_of_contact(const RigState& rig, MonoTime t, double travel_m);

// The travel by which a motion that starts now must have reached `force_N`; nullopt: unknown.
std::optional<double> furthest_m(const RigState& rig, MonoTime now, double force_N);

// Sets from where the force of a motion has to rise. `start_N`: beyond zero.
void set_base(Course::Pressed& pressed, const Contact::Least& contact,
              std::optional<double> travel_m, double start_N);

}  // namespace lcrig
