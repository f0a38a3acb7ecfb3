// SPDX-License-Identifier: Apache-2.0
// Sets a flag for as long as a scope lasts, also when the coroutine in it is cancelled. Motions and
// Distrust use it.
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
