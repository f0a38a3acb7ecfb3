// SPDX-License-Identifier: Apache-2.0
// Defines LCRIG_SANITIZED when this build has AddressSanitizer or ThreadSanitizer. These bring a
// heap of their own and switch mlockall off. g++ and clang report them differently.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LCRIG_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define LCRIG_SANITIZED 1
#endif
#endif
#ifndef LCRIG_SANITIZED
#define LCRIG_SANITIZED 0
#endif
