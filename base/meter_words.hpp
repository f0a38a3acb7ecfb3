// SPDX-License-Identifier: Apache-2.0
// Settings and corrections of an LCR meter. Their words are part of protocol files, the database,
// the control socket and the command line. Used by drivers, storage, analysis and the daemon.
#pragma once

#include "base/enum_words.hpp"

namespace lcrig {

// The impedance functions of the LCR-6000 dialect that the rig uses (reference manual: FUNCtion).
// The words are the instrument's own.
enum class LcrFunction { CpD, CpRp, CsD, CsRs, RX, ZThr, ZThd };
template <>
inline constexpr EnumWords<7> kWordsOf<LcrFunction>{"Cp-D", "Cp-Rp", "Cs-D", "Cs-Rs",
                                                    "R-X",  "Z-thr", "Z-thd"};
constexpr bool is_capacitance(LcrFunction function) {
  return function <= LcrFunction::CsRs;
}

enum class Aperture { fast, medium, slow };
template <>
inline constexpr EnumWords<3> kWordsOf<Aperture>{"fast", "medium", "slow"};

// bus: one conversion per request (*TRG), which is certainly newer than the request.
// internal: the meter converts continuously and is polled (FETC?); fastest.
enum class LcrTrigger { bus, internal };
template <>
inline constexpr EnumWords<2> kWordsOf<LcrTrigger>{"bus", "internal"};

enum class CorrectionKind { open, short_circuit };
template <>
inline constexpr EnumWords<2> kWordsOf<CorrectionKind>{"open", "short"};

}  // namespace lcrig
