// SPDX-License-Identifier: Apache-2.0
// Text for SVG and HTML: made harmless, measured, cut and wrapped.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lcrig::plot {

// For element content and for attributes in either kind of quotes. A control character becomes its
// picture (U+2400 ff.), line feed and tab stay; bytes that are no UTF-8 and characters that
// reorder text (U+202A..E, U+2066..9) become U+FFFD.
std::string escape(std::string_view text);

// Width in pixels of `text` (not escaped) in a sans-serif face, rather too large than too small.
double text_width(std::string_view text, double font_size);
// Cut at the end with an ellipsis so that it is at most `width` wide.
std::string cut_to_width(std::string_view text, double width, double font_size);
// Broken at blanks; a longer word is cut.
std::vector<std::string> wrap(std::string_view text, double width, double font_size);

}  // namespace lcrig::plot
