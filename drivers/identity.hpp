// SPDX-License-Identifier: Apache-2.0
// What an instrument reports about itself. Meters and frames answer with it.
#pragma once

#include <string>

namespace lcrig {

struct Identity {
  std::string maker, model, firmware, serial;
  std::string text;  // the reply exactly as sent
  bool simulated = false;  // the instrument itself says so
};

}  // namespace lcrig
