// SPDX-License-Identifier: Apache-2.0
// Physical quantities as types, so that a wrong unit does not compile. Values are always coherent
// SI. Used by the instrument interfaces, the model and the protocols.
#pragma once

#include <compare>

namespace lcrig {

// Exponents of length, mass, time and current; `.si()` is the value in m^L kg^M s^T A^I.
template <int L, int M, int T, int I>
class Quantity {
 public:
  constexpr Quantity() = default;
  static constexpr Quantity from_si(double value) { return Quantity(value); }
  constexpr double si() const { return value_; }

  constexpr auto operator<=>(const Quantity&) const = default;
  constexpr Quantity operator-() const { return Quantity(-value_); }
  constexpr Quantity& operator+=(Quantity o) { return value_ += o.value_, *this; }
  constexpr Quantity& operator-=(Quantity o) { return value_ -= o.value_, *this; }
  friend constexpr Quantity operator+(Quantity a, Quantity b) { return a += b; }
  friend constexpr Quantity operator-(Quantity a, Quantity b) { return a -= b; }
  friend constexpr Quantity operator*(Quantity a, double k) { return Quantity(a.value_ * k); }
  friend constexpr Quantity operator*(double k, Quantity a) { return a * k; }
  friend constexpr Quantity operator/(Quantity a, double k) { return Quantity(a.value_ / k); }
  friend constexpr double operator/(Quantity a, Quantity b) { return a.value_ / b.value_; }

 private:
  constexpr explicit Quantity(double value) : value_(value) {}
  double value_ = 0;
};

template <int L1, int M1, int T1, int I1, int L2, int M2, int T2, int I2>
constexpr auto operator*(Quantity<L1, M1, T1, I1> a, Quantity<L2, M2, T2, I2> b) {
  return Quantity<L1 + L2, M1 + M2, T1 + T2, I1 + I2>::from_si(a.si() * b.si());
}
template <int L1, int M1, int T1, int I1, int L2, int M2, int T2, int I2>
  requires(L1 != L2 || M1 != M2 || T1 != T2 || I1 != I2)
constexpr auto operator/(Quantity<L1, M1, T1, I1> a, Quantity<L2, M2, T2, I2> b) {
  return Quantity<L1 - L2, M1 - M2, T1 - T2, I1 - I2>::from_si(a.si() / b.si());
}

using Length = Quantity<1, 0, 0, 0>;
using Area = Quantity<2, 0, 0, 0>;
using Mass = Quantity<0, 1, 0, 0>;
using Velocity = Quantity<1, 0, -1, 0>;
using Acceleration = Quantity<1, 0, -2, 0>;
using Force = Quantity<1, 1, -2, 0>;
using ForceRate = Quantity<1, 1, -3, 0>;
using Stiffness = Quantity<0, 1, -2, 0>;
using Pressure = Quantity<-1, 1, -2, 0>;
using Frequency = Quantity<0, 0, -1, 0>;
using Voltage = Quantity<2, 1, -3, -1>;
using Capacitance = Quantity<-2, -1, 4, 2>;

inline constexpr double kStandardGravity_m_s2 = 9.80665;  // used where the local value is not
                                                          // stated

inline namespace literals {
// A literal is the SI value times the unit's factor.
#define LCRIG_UNIT(suffix, Type, factor)                     \
  constexpr Type operator""_##suffix(long double v) {        \
    return Type::from_si(static_cast<double>(v) * (factor)); \
  }
LCRIG_UNIT(m, Length, 1.0)
LCRIG_UNIT(mm, Length, 1e-3)
LCRIG_UNIT(mm_s, Velocity, 1e-3)
LCRIG_UNIT(m_s2, Acceleration, 1.0)
LCRIG_UNIT(N, Force, 1.0)
LCRIG_UNIT(N_s, ForceRate, 1.0)
LCRIG_UNIT(N_mm, Stiffness, 1e3)
LCRIG_UNIT(kPa, Pressure, 1e3)
LCRIG_UNIT(Hz, Frequency, 1.0)
LCRIG_UNIT(kHz, Frequency, 1e3)
LCRIG_UNIT(V, Voltage, 1.0)
LCRIG_UNIT(pF, Capacitance, 1e-12)
LCRIG_UNIT(fF, Capacitance, 1e-15)
#undef LCRIG_UNIT
}  // namespace literals

}  // namespace lcrig
