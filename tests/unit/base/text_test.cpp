// SPDX-License-Identifier: Apache-2.0
#include "base/text.hpp"

#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <sstream>

#include "base/log.hpp"
#include "tests/support/hostile_texts.hpp"

namespace lcrig {
namespace {

using support::expect_harmless_on_a_terminal;
using support::hostile_texts;
using testing::HasSubstr;

TEST(Printable, EscapesWhatATerminalObeys) {
  EXPECT_EQ(printable("a\x1b[31m\n\x7f"), "a\\x1b[31m\\x0a\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J"),
            "\\u009b2J");
  EXPECT_EQ(printable("\x9b"
                      "2J\xff"),
            "\\x9b2J\\xff");
  EXPECT_EQ(printable("a\u202Eb\u2028"), "a\\u202eb\\u2028");
  EXPECT_EQ(printable("C0 = 3 µF, 测试 😀"), "C0 = 3 µF, 测试 😀");
}

TEST(Printable, MakesOneHarmlessLineOfEveryHostileText) {
  for (const auto& [name, text] : hostile_texts()) {
    expect_harmless_on_a_terminal(printable(text, 500), 0, name);
    EXPECT_EQ(printable(printable(text)), printable(text)) << name << ": twice is once";
  }
}

TEST(Printable, SaysWhatItLeftOut) {
  EXPECT_EQ(printable("abcdef", 6), "abcdef");
  EXPECT_EQ(printable("abcdef", 3), "abc… (6 bytes)");
  EXPECT_EQ(printable("µµµ", 2), "µµ… (6 bytes)");
  EXPECT_EQ(printable("", 2), "");
}

TEST(Printable, KeepsTheLinesOfAFile) {
  EXPECT_EQ(printable_lines("{\n\t\"a\": 1 // \x1b[2J\r\n}"), "{\n\t\"a\": 1 // \\x1b[2J\\x0d\n}");
}

TEST(Utf8, TakesCharactersAndBytesThatAreNone) {
  std::string_view text = "aµ\xff";
  EXPECT_EQ(take_character(text), U'a');
  EXPECT_EQ(take_character(text), U'µ');
  EXPECT_EQ(take_character(text), kNotUtf8);
  EXPECT_TRUE(text.empty());
  for (const std::string bad : {"\xc3", "\xc0\xbc", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\x80"}) {
    EXPECT_FALSE(is_utf8(bad));
  }
  EXPECT_TRUE(is_utf8("µ测😀"));
}

TEST(CheckText, RefusesWhatIsTooLongNoUtf8OrHoldsANul) {
  EXPECT_TRUE(check_text("note", "fine\n\x1b[31m", 100));
  const auto error = [](std::string_view text) { return check_text("note", text, 10).error(); };
  EXPECT_EQ(error("12345678901").what, "note: 11 bytes, expected at most 10");
  EXPECT_EQ(error("12345678901").code, Errc::invalid_request);
  EXPECT_THAT(error("\xff").what, HasSubstr("UTF-8"));
  EXPECT_THAT(error({"a\0b", 3}).what, HasSubstr("NUL"));
}

// One message is one line, whatever it quotes, in the journal and on a terminal.
TEST(Log, AMessageIsOneHarmlessLine) {
  for (const bool journal : {true, false}) {
    std::ostringstream out;
    auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(out);
    sink->set_formatter(log_formatter(journal));
    spdlog::logger logger("test", sink);
    for (const auto& [name, text] : hostile_texts()) {
      out.str("");
      logger.warn("run 7 ended: {}", text);
      expect_harmless_on_a_terminal(out.str(), 1, name);
      EXPECT_TRUE(out.str().ends_with('\n')) << name;
      EXPECT_EQ(out.str().starts_with("<4>run 7 ended: "), journal) << name;
    }
  }
}

}  // namespace
}  // namespace lcrig
