// SPDX-License-Identifier: Apache-2.0
// A state that lasts as long as a scope, also when the coroutine in it is cancelled.
#pragma once

namespace lcrig {

class ScopedFlag {
 public:
  explicit ScopedFlag(bool& flag) : flag_(flag) { flag_ = true; }
  ~ScopedFlag() { flag_ = false; }
  ScopedFlag(const ScopedFlag&) = delete;
  ScopedFlag& operator=(const ScopedFlag&) = delete;

 private:
  bool& flag_;
};

}  // namespace lcrig
