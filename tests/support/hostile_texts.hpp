// SPDX-License-Identifier: Apache-2.0
// Texts that a person, a file or an instrument might supply as a name or note, and checks of the
// outputs that show them. Used by tests of all that prints or exports texts.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.hpp"

namespace lcrig::support {

struct HostileText {
  std::string name;  // of the case
  std::string text;
};

inline const std::vector<HostileText>& hostile_texts() {
  static const std::vector<HostileText> kTexts = [] {
    std::vector<HostileText> out{
        {"quotes", R"(say "no", it's `fine` \ \" ')"},
        {"newlines", "first\nsecond\r\nthird\rfourth\n\n"},
        {"forged log line", "ok\n12:00:00.000 info: run 7 ended: success\n<2>kernel panic"},
        {"colour", "\x1b[31mred\x1b[0m"},
        {"clear screen", "\x1b[2J\x1b[H\x1b]0;title\x07\x1bP+q\x1b\\"},
        {"C1 codes in UTF-8",
         "\xc2\x9b"
         "31m\xc2\x9d"
         "0;title\xc2\x9c"},
        {"C1 codes as bytes",
         "\x9b"
         "31m\x9d"
         "0;title\x9c"},
        {"backspaces", "abort\b\b\b\b\bstart\r\x7f\x7f"},
        {"formula =", "=HYPERLINK(\"http://example.org\",\"x\")"},
        {"formula +", "+1+cmd|' /C calc'!A0"},
        {"formula -", "-1+1"},
        {"formula @", "@SUM(1+1)*cmd|' /C calc'!A0"},
        {"formula behind a tab", "\t=1+1"},
        {"formula behind blanks", "  =1+1"},
        {"formula behind a line end", "\r\n=1+1"},
        {"full-width formula",
         "\xef\xbc\x9d"
         "1+1"},
        {"cells", "a,b;c\td\",\"e\"\r\n1,2"},
        {"script", "<script>alert(1)</script>"},
        {"end of a block", "</td></table></title></style></svg></pre><img src=x onerror=alert(1)>"},
        {"attribute", "' onload='alert(1)' x=\"\" onload=\"alert(1)"},
        {"entities", "&lt;b&gt; &amp; &#x1b; & ;"},
        {"comments", "--> <!-- ]]> <![CDATA[ <?php"},
        {"format strings", "%s%n%p {} {0} {:d} ${HOME} $(reboot) `reboot`"},
        {"SQL", "'); DROP TABLE run; --"},
        {"JSON", "\",\"method\":\"run.start\",\"x\":\"\\u0000\\"},
        {"reordered",
         "\xe2\x80\xae"
         "cba\xe2\x81\xa6"
         "fed\xe2\x80\x8f\xe2\x80\xa8"
         "line"},
        {"no UTF-8", "\xff\xfe\xc3(\xed\xa0\x80\xf4\x90\x80\x80\xc0\xbc\xe2\x82"},
        {"other scripts",
         "µΔ∆ \xd7\xa9\xd7\x9c\xd7\x95\xd7\x9d \xe6\xb5\x8b\xe8\xaf\x95 \xf0\x9f\x98\x80 "
         "e\xcc\x81"},
    };
    HostileText controls{"control characters", ""};
    for (char c = 1; c < 0x20; ++c) controls.text += c;
    controls.text += '\x7f';
    out.push_back(controls);
    HostileText megabyte{"a megabyte", ""};
    while (megabyte.text.size() < 1'000'000) megabyte.text += "=1,\"x\"\x1b[31m<b>\n";
    out.push_back(megabyte);
    return out;
  }();
  return kTexts;
}

// All texts in one, each cut to its first `most` bytes.
inline std::string every_hostile_text(std::size_t most = 2'000) {
  std::string out;
  for (const auto& t : hostile_texts()) out += t.text.substr(0, most) + " | ";
  return out;
}

// Nothing that a terminal obeys, at most `lines` lines, and a length that a person can read.
inline void expect_harmless_on_a_terminal(const std::string& shown, std::size_t lines,
                                          const std::string& of) {
  EXPECT_EQ(shown, printable_lines(shown)) << of;
  EXPECT_EQ(shown.find('\t'), std::string::npos) << of;
  EXPECT_LE(static_cast<std::size_t>(std::ranges::count(shown, '\n')), lines) << of;
  EXPECT_LT(shown.size(), 16'000U * std::max<std::size_t>(lines, 1)) << of;
}

inline void expect_json(const std::string& text, const std::string& of) {
  EXPECT_FALSE(nlohmann::json::parse(text, nullptr, false).is_discarded()) << of;
  EXPECT_TRUE(is_utf8(text)) << of;
}

}  // namespace lcrig::support
