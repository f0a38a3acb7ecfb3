// SPDX-License-Identifier: Apache-2.0
#include "daemon/service.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/support/sanitized.hpp"
#include "tests/support/without_rights.hpp"

namespace lcrig {
namespace {

constexpr bool kSanitized = LCRIG_SANITIZED;

std::string of_this_process(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key)) return line.substr(key.size());
  }
  return {};
}

double locked_MB() {
  return std::stod(of_this_process("VmLck:")) / 1024;
}

bool may_lock() {
  rlimit limit{};
  ::getrlimit(RLIMIT_MEMLOCK, &limit);
  const auto rights = std::stoull(of_this_process("CapEff:"), nullptr, 16);
  return limit.rlim_cur == RLIM_INFINITY || (rights >> CAP_IPC_LOCK & 1) != 0;
}

// Each runs in a process of its own.
int locked_with_rights() {
  return lock_memory() && locked_MB() > 1 ? 0 : 1;
}

// A small limit that only another process could raise.
int locked_without_rights() {
  const WithoutResourceRights less;
  const rlimit small{65536, 65536};
  ::setrlimit(RLIMIT_MEMLOCK, &small);
  if (lock_memory() || locked_MB() != 0) return 1;
  const std::vector<char> memory(100'000'000, 'x');  // memory can still be had
  return memory.back() == 'x' ? 0 : 2;
}

TEST(LockMemory, KeepsTheWholeProgramWhereThatIsAllowed) {
  if (kSanitized) GTEST_SKIP() << "mlockall does nothing under a sanitizer";
  if (!may_lock()) GTEST_SKIP() << "needs CAP_IPC_LOCK, or `ulimit -l unlimited`";
  EXPECT_EXIT(std::_Exit(locked_with_rights()), testing::ExitedWithCode(0), "");
}

TEST(LockMemory, ChangesNothingWhereItIsNotAllowed) {
  if (kSanitized) GTEST_SKIP() << "mlockall does nothing under a sanitizer";
  EXPECT_EXIT(std::_Exit(locked_without_rights()), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace lcrig
