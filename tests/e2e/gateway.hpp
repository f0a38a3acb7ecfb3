// SPDX-License-Identifier: Apache-2.0
// A rig whose frame is the reference gateway in Python (tools/gateway), which has a simulated
// machine and keeps its own record of the truth. The meter is lcrig-sim's. Used by gateway_test.cpp
// and lies_test.cpp.
#pragma once

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {

// Travel 0 to 60 mm with contact at 30, 120 N/mm, a device that reacts within 8 ms.
extern const std::vector<std::string> kForeign;

class Gateway : public Rig {
 protected:
  void start_rig(const std::vector<std::string>& machine = kForeign,
                 const std::vector<std::string>& options = {});
  void TearDown() override;
  // Ends the gateway and returns the summary of the true values that it writes at its end.
  json end_gateway();
  std::vector<json> truth() const;  // the lines of the record so far
  json foreign_config(std::optional<double> stiffness_N_mm = 150) const;
  std::string panel(const std::string& order) const;  // returns the answer

  std::unique_ptr<Child> gateway_;
  json ready_;
};

// Zeroes, searches for contact, loads to 0.8 N, waits 3 s there and unloads.
std::string foreign_protocol(const std::string& contact_mm_s, const std::string& load_mm_s);

}  // namespace lcrig::e2e
