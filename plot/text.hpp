// SPDX-License-Identifier: Apache-2.0
// Escapes, measures, cuts and wraps text for SVG and HTML. Used by plot/ and by the report.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lcrig::plot {

// For element content and for attributes in either kind of quotes. Control characters become their
// pictures (U+2400 ff.) except line feed and tab. Bytes that are not UTF-8 and characters that
// reorder text (U+202A..E, U+2066..9) become U+FFFD.
std::string escape(std::string_view text);

// Width in pixels of unescaped `text` in a sans-serif face; too large rather than too small.
double text_width(std::string_view text, double font_size);
// Cuts the text at the end, with an ellipsis, to at most `width`.
std::string cut_to_width(std::string_view text, double width, double font_size);
// Breaks the text at blanks and cuts words that are wider than `width`.
std::vector<std::string> wrap(std::string_view text, double width, double font_size);

}  // namespace lcrig::plot
