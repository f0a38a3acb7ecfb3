// SPDX-License-Identifier: Apache-2.0
#include "base/strict_json.hpp"
#include "base/near_word.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/hostile_texts.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string error_of(const std::string& text) {
  const auto r = JsonDocument::parse(text, "f.json");
  return r ? "accepted" : r.error().what;
}

JsonDocument parsed(const std::string& text) {
  auto r = JsonDocument::parse(text, "f.json");
  if (!r) throw std::runtime_error(r.error().what);
  return *r;
}

TEST(StrictJson, PositionsOfKeysAndValuesAreKept) {
  const auto d = parsed(
      "// a comment with \"quotes\" and {\n{ \"a\": [1, -2.5e3,\n   true, \"x\\\"]\"],\n"
      " \"µ/~\" : {\"b\":null} }  // end");
  EXPECT_EQ(d.key_position("/a").line, 2);
  EXPECT_EQ(d.key_position("/a").column, 3);
  EXPECT_EQ(d.value_position("/a/1").column, 12);
  EXPECT_EQ(d.value_position("/a/2").line, 3);
  EXPECT_EQ(d.value_position("/a/3").column, 10);
  EXPECT_EQ(d.key_position("/µ~1~0").line, 4);
  EXPECT_EQ(d.value_position("/µ~1~0").column, 10);  // characters, not bytes
  EXPECT_EQ(d.value_position("/µ~1~0/b").column, 15);
  EXPECT_TRUE(d.root()["µ/~"]["b"].is_null());
}

TEST(StrictJson, ADuplicateKeyIsRefusedWithBothPlacesAndHidesNothing) {
  const JsonReader root(parsed("{\"a\": {\n\"b\": 1,\n \"b\": 2},\n\"c\": \"x\"}"));
  root.object("a").number("b");
  root.number("c");
  const auto all = root.result();
  ASSERT_FALSE(all);
  EXPECT_EQ(all.error().what,
            "f.json:3:2 /a/b: the key `b` for the second time, expected once (first in line 2)");
  EXPECT_THAT(all.error().detail, HasSubstr("f.json:4:6 /c: \"x\", expected a number"));
}

TEST(StrictJson, TheSameKeyInTwoObjectsIsFine) {
  EXPECT_EQ(error_of("[{\"a\":1},{\"a\":2,\"b\":{\"a\":3}}]"), "accepted");
}

TEST(StrictJson, SyntaxErrorsNameThePlace) {
  EXPECT_THAT(error_of("{\"a\": 1,\n  \"b\" 2}"), StartsWith("f.json:2:6 /: a `:` is missing"));
  EXPECT_THAT(error_of(""), StartsWith("f.json:1:1 /: the file is empty"));
  EXPECT_THAT(error_of("[1,]"), HasSubstr("1:3 /: a `,` behind the last entry"));
  EXPECT_THAT(error_of("{} x"), HasSubstr("1:4 /: something follows the end"));
  EXPECT_THAT(error_of("[NaN]"), HasSubstr("`NaN` is no number"));
  EXPECT_THAT(error_of("[Infinity]"), HasSubstr("`Infinity` is no number"));
  EXPECT_THAT(error_of("[01]"), HasSubstr("does not begin with 0"));
  EXPECT_THAT(error_of("[\"\xff\"]"), HasSubstr("UTF-8"));
  EXPECT_THAT(error_of("{\"a\": \"x"), HasSubstr("1:7 /: the text that begins here is not closed"));
}

TEST(StrictJson, NumbersBeyondDoubleAreRefused) {
  EXPECT_THAT(error_of("{\"a\": 1e999}"), HasSubstr("`1e999` is beyond the largest number"));
}

TEST(StrictJson, BlockCommentsAreRefused) {
  EXPECT_THAT(error_of("{ \"a\": /* no */ 1 }"), StartsWith("f.json:1:8 /: a /* comment"));
  EXPECT_THAT(error_of("{} /* no */"), HasSubstr("a /* comment"));
  EXPECT_THAT(error_of("{\"a\"/* never closed"), HasSubstr("/* comment"));  // was an endless loop
  EXPECT_THAT(error_of("{} /*"), HasSubstr("/* comment"));
  EXPECT_EQ(error_of("{ \"a\": \"/* text */\" } // /* fine */"), "accepted");
}

TEST(StrictJson, DepthAndSizeAreLimited) {
  const auto nested = [](std::size_t n) { return std::string(n, '[') + std::string(n, ']'); };
  EXPECT_EQ(error_of(nested(64)), "accepted");
  EXPECT_THAT(error_of(nested(65)), HasSubstr("more than 64 levels"));
  EXPECT_THAT(error_of(nested(1'000'000)), HasSubstr("more than 64 levels"));
  EXPECT_THAT(error_of(std::string(kJsonSizeMax + 1, ' ')), HasSubstr("expected at most 4194304"));
}

// A position is kept for every value. A file of 1 MB must not become gigabytes of positions, or
// take minutes to compare names.
TEST(StrictJson, ASmallFileCannotEatAllMemory) {
  std::string zeros = "0", members;
  for (int i = 0; i < 200'000; ++i) zeros += ",0";
  for (int i = 0; i < 50'000; ++i) members += "\"m" + std::to_string(i) + "\":0,";
  EXPECT_THAT(error_of("[" + zeros + "]"), HasSubstr("more than 100000 values"));
  EXPECT_THAT(error_of("{\"" + std::string(300'000, 'k') + "\":[" + zeros + "]}"),
              HasSubstr("a key of 300000 bytes, expected at most 200"));
  std::string deep;
  for (int i = 0; i < 20; ++i) deep += "{\"" + std::string(150, 'k') + "\":";
  EXPECT_THAT(error_of(deep), HasSubstr("keys of 1057 bytes above one another"));
  const auto document = JsonDocument::parse("{" + members + "\"z\":0}", "f.json");
  ASSERT_TRUE(document);
  const JsonReader reader(*document);
  EXPECT_TRUE(reader.members().empty());
  EXPECT_THAT(reader.result().error().what, HasSubstr("50001 members, expected at most 1000"));
}

TEST(StrictJson, MessagesAreShortAndHarmless) {
  for (const auto& [name, text] : support::hostile_texts()) {
    for (const std::string& file :
         {text, "{\"" + text + "\": 1}", "[" + text + "]",
          nlohmann::json{{text.substr(0, 100), {{text.substr(0, 90), 0}}}}.dump(
              -1, ' ', true, nlohmann::json::error_handler_t::replace)}) {
      const auto document = JsonDocument::parse(file, text);
      std::string what;
      if (document) {
        const JsonReader reader(*document);
        reader.no_other_keys();
        what = reader.result().error().what;
      } else {
        what = document.error().what;
      }
      support::expect_harmless_on_a_terminal(what, 0, name);
    }
  }
}

TEST(StrictJson, ControlCharactersAreRefusedInOurWordsEverywhere) {
  using namespace std::string_literals;
  const std::string what = "the character \\x00, expected UTF-8 text without control characters";
  EXPECT_EQ(error_of("{ \"a\0b\": 1 }"s), "f.json:1:5 /: " + what);
  EXPECT_EQ(error_of("{ \"a\": \"b\0\" }"s), "f.json:1:10 /: " + what);
  EXPECT_EQ(error_of("// a\0b\n{ \"a\": 1 }"s), "f.json:1:5 /: " + what);
}

TEST(StrictJson, ControlCharactersAreRefusedInCommentsToo) {
  EXPECT_EQ(error_of("{} // \x1b[2J"),
            "f.json:1:7 /: the character \\x1b, expected UTF-8 text without control characters");
  EXPECT_THAT(error_of("// \xff\n{}"), HasSubstr("the byte \\xff is not UTF-8"));
  EXPECT_THAT(error_of("{ \"a\": \"\u202e\" }"), HasSubstr("the character \\u202e"));
  EXPECT_EQ(error_of("// µ\t测\r\n{}"), "accepted");
}

TEST(StrictJson, AByteOrderMarkIsSkipped) {
  EXPECT_EQ(parsed("\xEF\xBB\xBF[7]").value_position("/0").column, 2);
}

template <class F>
std::string read_error(const std::string& text, F read) {
  const auto d = parsed(text);
  const JsonReader r(d);
  read(r);
  return r.ok() ? "ok" : r.result().error().what;
}

TEST(JsonReader, TypesAreChecked) {
  const auto number = [](const JsonReader& r) { (void)r.number("a"); };
  EXPECT_EQ(read_error("{\"a\": \"1\"}", number), "f.json:1:7 /a: \"1\", expected a number");
  EXPECT_EQ(read_error("{\"a\": null}", number), "f.json:1:7 /a: null, expected a number");
  EXPECT_EQ(read_error("{\"b\": 1}", number), "f.json:1:1 /: the key `a` is missing, found b");
  EXPECT_EQ(read_error("[]", number), "f.json:1:1 /: an array, expected an object");
}

TEST(JsonReader, IntegersAreNotTruncated) {
  const auto integer = [](const JsonReader& r) { (void)r.integer("a", 1, 5); };
  EXPECT_EQ(read_error("{\"a\": 5.0}", integer), "ok");
  EXPECT_EQ(read_error("{\"a\": 2.7}", integer),
            "f.json:1:7 /a: 2.7, expected a whole number from 1 to 5");
  EXPECT_NE(read_error("{\"a\": 6}", integer), "ok");
  EXPECT_NE(read_error("{\"a\": 18446744073709551615}", integer), "ok");
  EXPECT_NE(read_error("{\"a\": 1e300}", integer), "ok");
}

TEST(JsonReader, RangesAreChecked) {
  const auto positive = [](const JsonReader& r) { (void)r.number("a", kPositive); };
  EXPECT_EQ(read_error("{\"a\": 0}", positive), "f.json:1:7 /a: 0, expected greater than 0");
  const auto range = [](const JsonReader& r) { (void)r.number("a", Range{0, 0.5}); };
  EXPECT_EQ(read_error("{\"a\": 0.6}", range), "f.json:1:7 /a: 0.6, expected from 0 to 0.5");
}

TEST(JsonReader, UnknownKeysAreRefusedWithTheKnownOnes) {
  const auto read = [](const JsonReader& r) {
    (void)r.number("speed");
    (void)r.optional_quantity("force", Dimension::force);
    r.no_other_keys();
  };
  EXPECT_EQ(read_error("{\"speed\": 1, \"force_N\": 2}", read), "ok");
  EXPECT_EQ(read_error("{\"speed\": 1, \"forse_N\": 2}", read),
            "f.json:1:14 /forse_N: unknown key `forse_N`, did you mean `force_N`? expected speed, "
            "force_(mN|N|kN)");
  EXPECT_THAT(read_error("{\"speed\": 1, \"banana\": 2}", read),
              HasSubstr("unknown key `banana`, expected speed"));
}

// 200 kPa read as 200 Pa would be a valid file, so a unit is never guessed.
TEST(JsonReader, AUnitThatNobodyWroteIsNeverProposed) {
  const auto read = [](const JsonReader& r) {
    (void)r.optional_quantity("stiffness", Dimension::stiffness);
    (void)r.optional_quantity("speed", Dimension::speed);
    (void)r.optional_number("gravity_m_s2");
    r.no_other_keys();
  };
  const std::string stiffness = "it takes stiffness_N_m, stiffness_N_mm, stiffness_N_um";
  const std::string speed = "it takes speed_um_s, speed_mm_s, speed_mm_min, speed_m_s";
  const struct {
    const char* key;
    std::string says;
  } cases[] = {
      {"stiffness", "`stiffness` has no unit; " + stiffness},
      {"stifness",
       "unknown key `stifness`, did you mean `stiffness`? With its unit it is "
       "stiffness_N_m, "},
      {"stifness_N_mm", "did you mean `stiffness_N_mm`?"},
      {"stiffness_N_cm", "`_N_cm` is no unit of stiffness; " + stiffness},
      {"stiffness_N", "`_N` is no unit of stiffness; " + stiffness},
      {"speed_cm_s", "`_cm_s` is no unit of speed; " + speed},
      {"speed_mm_per_s", "`_mm_per_s` is no unit of speed; " + speed},
      {"speed_MM_S", "`_MM_S` is no unit of speed; " + speed},
      {"sped_mm_s", "did you mean `speed_mm_s`?"},
      {"speedmm_s", "did you mean `speed_mm_s`?"},
      {"Speed-mm-S", "did you mean `speed_mm_s`?"},
      {"gravity", "`gravity` has no unit; it takes gravity_m_s2"},
      {"gravity_mm_s2", "`_mm_s2` is not known here; it takes gravity_m_s2"},
  };
  for (const auto& c : cases) {
    const std::string error = read_error(fmt::format("{{\"{}\": 200}}", c.key), read);
    EXPECT_THAT(error, HasSubstr(c.says));
    const bool guesses = std::string(c.key).find("_N_mm") == std::string::npos &&
                         error.find("did you mean `stiffness_") != std::string::npos;
    EXPECT_FALSE(guesses) << error;
  }
}

TEST(JsonReader, QuantitiesAreConvertedByTheirSuffix) {
  const auto d = parsed("{\"thickness_um\": 25, \"speed_mm_s\": 16, \"wait_ms\": 10}");
  const JsonReader r(d);
  EXPECT_DOUBLE_EQ(r.quantity("thickness", Dimension::length, Range{0, 1e-4}), 25e-6);
  EXPECT_DOUBLE_EQ(r.quantity("speed", Dimension::speed), 16e-3);
  EXPECT_DOUBLE_EQ(*r.optional_quantity("wait", Dimension::time), 0.01);
  EXPECT_FALSE(r.optional_quantity("width", Dimension::length));
  r.no_other_keys();
  EXPECT_TRUE(r.ok()) << r.result().error().what;
}

TEST(JsonReader, WrongUnitsAreRefusedWithTheRightOnes) {
  const auto read = [](const JsonReader& r) {
    (void)r.quantity("force", Dimension::force, Range{0, 5});
  };
  EXPECT_EQ(
      read_error("{\"force_mm\": 1}", read),
      "f.json:1:2 /force_mm: `force_mm`: `_mm` is no unit of force; it takes force_mN, force_N, "
      "force_kN");
  EXPECT_THAT(read_error("{\"force_lbf\": 1}", read), HasSubstr("`_lbf` is no unit of force"));
  EXPECT_THAT(read_error("{\"force\": 1}", read),
              HasSubstr("`force` has no unit; it takes force_mN, force_N, force_kN"));
  EXPECT_THAT(read_error("{}", read), HasSubstr("is missing"));
  EXPECT_EQ(read_error("{\"force_mN\": 5001}", read),
            "f.json:1:14 /force_mN: 5001, expected from 0 to 5000");
  EXPECT_THAT(read_error("{\"force_N\": 1, \"force_mN\": 1}", read),
              HasSubstr("expected only one of them"));
}

TEST(JsonReader, WordsComeFromTheTable) {
  static constexpr std::pair<std::string_view, int> kTable[] = {{"fast", 1}, {"slow", 2}};
  const auto word = [](const JsonReader& r) { (void)r.word<int>("a", kTable); };
  EXPECT_EQ(JsonReader(parsed("\"slow\"")).word<int>(kTable), 2);
  EXPECT_EQ(read_error("{\"a\": \"fasst\"}", word),
            "f.json:1:7 /a: \"fasst\", did you mean `fast`? expected one of fast, slow");
  EXPECT_EQ(read_error("{\"a\": 3}", word), "f.json:1:7 /a: 3, expected a string");
}

TEST(JsonReader, TheFirstFailureIsKept) {
  const auto d = parsed("{\"a\": \"x\", \"b\": \"y\"}");
  const JsonReader r(d);
  (void)r.number("a");
  (void)r.number("b");
  EXPECT_THAT(r.result().error().what, HasSubstr("/a:"));
  EXPECT_EQ(r.result().error().code, Errc::invalid_request);
}

TEST(JsonReader, ControlCharactersDoNotReachTheTerminal) {
  const std::string text = "{\"\\u001b[2J\": 1}";
  const auto read = [](const JsonReader& r) { r.no_other_keys(); };
  EXPECT_EQ(read_error(text, read).find('\x1b'), std::string::npos);
}

TEST(LoadJson, AMissingFileSaysWhy) {
  const auto r = load_json("/nonexistent/x.json");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::io);
  EXPECT_THAT(r.error().what, HasSubstr("No such file"));
}

TEST(Units, TheLongestSuffixWins) {
  EXPECT_EQ(split_key("speed_mm_s").stem, "speed");
  EXPECT_EQ(split_key("speed_mm_s").dimension(), Dimension::speed);
  EXPECT_EQ(split_key("poll_interval_ms").stem, "poll_interval");
  EXPECT_EQ(split_key("cycles").unit, nullptr);
  EXPECT_EQ(split_key("_mm").unit, nullptr);
  EXPECT_EQ(split_key("").unit, nullptr);
}

TEST(Units, EverySuffixIsUniqueAndFindsItself) {
  for (const Unit& unit : all_units()) {
    EXPECT_EQ(find_unit(unit.suffix), &unit) << unit.suffix;
    EXPECT_EQ(split_key("x_" + std::string(unit.suffix)).unit, &unit) << unit.suffix;
  }
}

TEST(Units, SlipsOfTheFingersAreRecognised) {
  const std::vector<std::string> known{"force_N", "speed_mm_s", "id"};
  EXPECT_EQ(nearest_word("force_n", known), "force_N");
  EXPECT_EQ(nearest_word("sped_mm_s", known), "speed_mm_s");
  EXPECT_FALSE(nearest_word("colour", known));
}

TEST(NearWord, NothingIsProposedThatSomebodyMayNotMean) {
  const std::vector<std::string> known{"Cp-D",    "Cp-Rp",       "Cs-D",           "paper-1",
                                       "paper-2", "bonded_base", "bonded_laminate"};
  EXPECT_FALSE(nearest_word("Cp-Q", known)) << "a function of another meter";
  EXPECT_FALSE(nearest_word("paper-9", known));
  EXPECT_FALSE(nearest_word("bonded", known)) << "two fit";
  EXPECT_EQ(did_you_mean("bonded", known), ", did you mean `bonded_base` or `bonded_laminate`?");
  EXPECT_EQ(did_you_mean("paper", known), ", did you mean `paper-1` or `paper-2`?");
  EXPECT_EQ(or_comma(did_you_mean("colour", known)), ",");
  EXPECT_EQ(guess_words("--seed", kGuessAtPrompt), "; did you mean '--seed'?");
  EXPECT_EQ(or_comma(guess_words(nearest_word("papr-1", known))), ", did you mean `paper-1`?");
  EXPECT_EQ(nearest_word("papr-1", known), "paper-1");
  EXPECT_EQ(nearest_word("cp-d", known), "Cp-D") << "only the capitals differ";
  EXPECT_EQ(nearest_word("PAPER-2", known), "paper-2");
}

TEST(Units, OfNamesThatNobodyKnowsAreNamed) {
  const auto unknown = [](std::string_view name) {
    const auto found = find_unknown_unit(name);
    return found ? fmt::format("{} {}", found->suffix, to_string(found->dimension)) : "";
  };
  EXPECT_EQ(unknown("speed_cm_s"), "cm_s speed") << "it is no time";
  EXPECT_EQ(unknown("gap_inch"), "inch length");
  EXPECT_EQ(unknown("from_bar"), "bar pressure");
  EXPECT_EQ(unknown("rate_N_h"), "N_h force rate");
  EXPECT_EQ(unknown("rate_lbf_s"), "lbf_s force rate");
  EXPECT_EQ(unknown("force_kn"), "kn force") << "capitals make a unit another one";
  for (const auto* name : {"cycles", "force_limit_N", "speed_mm_s", "hold_min_s", "rate_N_min",
                           "force_limit", "level_n", "rest_h", "stiffness_N_mm", "a_b_c"}) {
    EXPECT_EQ(unknown(name), "") << name;
  }
  for (const Unit& unit : all_units()) {
    EXPECT_EQ(unknown("x_" + std::string(unit.suffix)), "") << unit.suffix;
  }
}

TEST(StrictJson, LinesThatEndWithCarriageReturnsAreCounted) {
  EXPECT_THAT(error_of("{\r \"a\": 1,\r \"b\" 2\r}"), StartsWith("f.json:3:5 /: a `:` is missing"));
  EXPECT_THAT(error_of("{\r\n \"a\": 1,\r\n \"b\" 2\r\n}"), StartsWith("f.json:3:5 "));
  const auto d = parsed("// one\r{ \"a\":\r 1 }");
  EXPECT_EQ(d.key_position("/a").line, 2);
  EXPECT_EQ(d.value_position("/a").line, 3);
  EXPECT_EQ(excerpt(d.text(), d.key_position("/a")), "{ \"a\":\n  ^");
}

TEST(TextFile, APipeGivesWhatIsWrittenAndIsNotWaitedForWithoutAWriter) {
  const TempDir dir;
  const std::string pipe = dir.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(read_text_file(pipe).value_or("?"), "");
  const int writes = ::open(pipe.c_str(), O_RDWR | O_CLOEXEC);
  const int keeps = ::open(pipe.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // what was written
  std::thread writer([&] {
    for (const char* part : {"{ \"a\":", " 1 }"}) {
      EXPECT_GT(::write(writes, part, std::strlen(part)), 0);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    ::close(writes);
  });
  const auto text = read_text_file(pipe);
  writer.join();
  ::close(keeps);
  ASSERT_TRUE(text) << text.error().what;
  EXPECT_EQ(*text, "{ \"a\": 1 }");
  EXPECT_THAT(require_plain_file(pipe).error().what, HasSubstr("a pipe or a device"));
  EXPECT_TRUE(require_plain_file(dir.file("nothing"))) << "opening it says what is wrong";
}

}  // namespace
}  // namespace lcrig
