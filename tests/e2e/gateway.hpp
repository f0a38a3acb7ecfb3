// SPDX-License-Identifier: Apache-2.0
// A rig whose frame is the reference gateway in Python (tools/gateway), with a simulated machine
// and a witness of its own; the meter is lcrig-sim's.
#pragma once

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {

// Contact at 30 mm of 0 to 60, 120 N/mm, a device that reacts within 8 ms.
extern const std::vector<std::string> kForeign;

class Gateway : public Rig {
 protected:
  void start_rig(const std::vector<std::string>& machine = kForeign,
                 const std::vector<std::string>& options = {});
  void TearDown() override;
  // Its last words: the sums of what was really there.
  json end_gateway();
  std::vector<json> truth() const;  // the witness's lines so far
  json foreign_config(std::optional<double> stiffness_N_mm = 150) const;
  std::string panel(const std::string& order) const;  // its answer

  std::unique_ptr<Child> gateway_;
  json ready_;
};

// Zero, search for contact, 0.8 N, 3 s there, up again.
std::string foreign_protocol(const std::string& contact_mm_s, const std::string& load_mm_s);

}  // namespace lcrig::e2e
