// SPDX-License-Identifier: Apache-2.0
// The report of several runs; inside the report only.
#pragma once

#include <span>
#include <string>

#include "analysis/report/report.hpp"

namespace lcrig::report {

std::string comparison_page(std::span<const ReportRun> runs);

}  // namespace lcrig::report
