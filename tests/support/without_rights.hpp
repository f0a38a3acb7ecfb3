// SPDX-License-Identifier: Apache-2.0
// Takes away the rights with which root passes every permission bit, so that tests of "no rights"
// give the same result for root and for other users.
#pragma once

#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <stdexcept>

namespace lcrig {

// Drops capabilities of this thread until the end of the scope.
class WithoutRights {
 public:
  explicit WithoutRights(std::uint32_t capabilities) {
    if (::syscall(SYS_capget, &header_, before_.data()) != 0) throw std::runtime_error("capget");
    auto less = before_;
    less[0].effective &= ~capabilities;
    if (::syscall(SYS_capset, &header_, less.data()) != 0) throw std::runtime_error("capset");
  }
  ~WithoutRights() { ::syscall(SYS_capset, &header_, before_.data()); }
  WithoutRights(const WithoutRights&) = delete;
  WithoutRights& operator=(const WithoutRights&) = delete;

 private:
  __user_cap_header_struct header_{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> before_{};
};

struct WithoutFileRights : WithoutRights {  // only permission bits count
  WithoutFileRights() : WithoutRights(1U << CAP_DAC_OVERRIDE | 1U << CAP_DAC_READ_SEARCH) {}
};

struct WithoutResourceRights : WithoutRights {  // resource limits apply
  WithoutResourceRights() : WithoutRights(1U << CAP_SYS_RESOURCE | 1U << CAP_IPC_LOCK) {}
};

// For the program that this process will become; may be called between fork and exec. A process
// without these rights has nothing to drop, and then the calls fail without harm.
inline void give_up_file_rights_at_exec() {
  ::prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE);
  ::prctl(PR_CAPBSET_DROP, CAP_DAC_READ_SEARCH);
}

}  // namespace lcrig
