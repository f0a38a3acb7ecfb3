// SPDX-License-Identifier: Apache-2.0
// Sets a flag while it lives, even if the coroutine is cancelled. Used by Motions and Responses.
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
