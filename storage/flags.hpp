// SPDX-License-Identifier: Apache-2.0
// The schema names this file as the place of the bits of its `flags` columns. They stand in base/,
// because drivers set them.
#pragma once

#include "base/flags.hpp"
