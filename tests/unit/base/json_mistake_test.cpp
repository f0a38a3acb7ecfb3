// SPDX-License-Identifier: Apache-2.0
#include "base/json_mistake.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/strict_json.hpp"

namespace lcrig {
namespace {

using ::testing::ElementsAre;

struct Case {
  const char* text;
  const char* message;  // after "f.json:"
};

// Mistakes that people type. A changed message shows up here as a diff.
const Case kMistakes[] = {
    {"", "1:1 /: the file is empty, expected an object: { ... }"},
    {" \n\n", "1:1 /: the file is empty, expected an object: { ... }"},
    {"// only a comment\n", "1:1 /: the file is empty, expected an object: { ... }"},
    {"{\n\"a\": 1\n\"b\": 2\n}", "2:7 /: a `,` is missing here"},
    {"{\"a\": [1 2]}", "1:9 /a: a `,` is missing here"},
    {"{\"a\": {\"b\": 1} \"c\": 2}", "1:15 /: a `,` is missing here"},
    {"{\"a\": 1,}", "1:8 /: a `,` behind the last entry: remove it"},
    {"{\"a\": 1, // last\n}", "1:8 /: a `,` behind the last entry: remove it"},
    {"[1, 2,]", "1:6 /: a `,` behind the last entry: remove it"},
    {"{\"a\": 1,, \"b\": 2}", "1:9 /: two commas without an entry between them"},
    {"{\"force_N\": 1,5}", "1:13 /: `1,5`: a decimal number is written with a point: 1.5"},
    {"{\"force_N\": 1,5, \"x\": 2}",
     "1:13 /: `1,5`: a decimal number is written with a point: 1.5"},
    // 1,000 is a thousand to some and one to others.
    {"{\"force_N\": 1,000}", "1:13 /: `1,000`: 1.000 or 1000? A number has no `,`"},
    {"{\"force_N\": 2,500, \"x\": 2}", "1:13 /: `2,500`: 2.500 or 2500? A number has no `,`"},
    {"{\"force_N\": -12,500}", "1:13 /: `-12,500`: -12.500 or -12500? A number has no `,`"},
    {"{\"force_N\": [1,000]}", "1:14 /force_N: `1,000`: 1.000 or 1000? A number has no `,`"},
    {"{\"force_N\": 0,500}", "1:13 /: `0,500`: a decimal number is written with a point: 0.500"},
    {"{\"force_N\": 1000,125}",
     "1:13 /: `1000,125`: a decimal number is written with a point: 1000.125"},
    {"{\"force_N\": 1,000.5}",
     "1:13 /: `1,000.5`: a number has no `,`; the decimal sign is a point"},
    {"{\"force_N\": 1.5N}",
     "1:13 /: `1.5N` is no number; a unit belongs to the key, as in \"force_N\": 1.5"},
    {"{\"t_s\": 10 s}",
     "1:12 /: a number has no unit; it belongs to the key, as in \"force_N\": 1.5"},
    {"{\"t_s\": 8%}",
     "1:10 /: a number has no unit; it belongs to the key, as in \"force_N\": 1.5"},
    {"{\"t_s\": 8*2}", "1:9 /: this is a calculation, expected its result alone"},
    {"{\"t_s\": 10 / 2, \"x\": 1}", "1:9 /: this is a calculation, expected its result alone"},
    {"{\"t_s\": 1 000}", "1:9 /: `1 000`: the digits of a number stand side by side"},
    {"{\"t_s\": 1 000 000 }", "1:9 /: `1 000 000`: the digits of a number stand side by side"},
    {"{\"t_s\": 1'000}", "1:9 /: `1'000`: the digits of a number stand side by side"},
    {"{\"a\": 1 'b': 2}", "1:9 /: keys and texts stand in double quotes: \"...\""},
    {"{\"t_s\": 0x10}", "1:9 /: `0x10`: a number is written with decimal digits"},
    {"{\"mm\": (-5, 5)}", "1:8 /: a list stands in square brackets: [ ... ]"},
    {"{\"mm\": {-5, 5}}", "1:8 /mm: a list stands in square brackets: [ ... ]"},
    {"{1: 2}", "1:2 /: a key stands in double quotes: \"1\""},
    {"<html><body>404</body></html>", "1:1 /: this is no JSON: with `<` begins a web page, or XML"},
    {"{\"a\": <1>}", "1:7 /: this begins no value"},
    {"{\"t_s\": 50%}",
     "1:11 /: a number has no unit; it belongs to the key, as in \"force_N\": 1.5"},
    {"{\"d\": 5 µm}", "1:9 /: a number has no unit; it belongs to the key, as in \"force_N\": 1.5"},
    {"{\"t_s\": 3'600}", "1:9 /: `3'600`: the digits of a number stand side by side"},
    {"{\"t_s\": 3 600}", "1:9 /: `3 600`: the digits of a number stand side by side"},
    {"{\"a\": 3\n4}", "1:8 /: a `,` is missing here"},
    {"{\"a\": [-0.2 .. 1.5]}",
     "1:13 /a: the two ends of a range stand in a list, with a `,` between them: [0, 1.5]"},
    {"{ , \"a\": 1}", "1:3 /: a `,` before the first entry: remove it"},
    {"{\"a\": yes}", "1:7 /: `yes`: JSON writes true"},
    {"{\"a\": Off}", "1:7 /: `Off`: JSON writes false"},
    {"{\"do\": \"find, \"speed\": 1}",
     "1:8 /: a `\"` is missing: the text that begins here goes up to the next one"},
    {"{\"a\": \"m\ts\"}", "1:9 /: a tab in a text is written `\\t`"},
    {"{\"a\": \"m\x01s\"}", "1:9 /: the control character U+0001 in a text is written `\\u0001`"},
    {"{\"a\": \"m\\u12\"}",
     "1:9 /: behind `\\u` stand four digits of 0 to 9 and a to f, as in \\u00b5"},
    {"{\"a\": \"m\\ud83d\"}",
     "1:9 /: `\\ud83d` is half of a character: write the character itself"},
    {"{\"a\": \"m\\ude00\"}",
     "1:9 /: `\\ude00` is half of a character: write the character itself"},
    {"{\"a\": \"\\ud83d\\ude00\" 1}", "1:21 /: a `,` is missing here"},
    {"# comment\n{}", "1:1 /: a comment begins with `//`, not with `#`"},
    {"{\"a\": 1 # one\n}", "1:9 /: a comment begins with `//`, not with `#`"},
    {"{} /* old */ {}", "1:4 /: a /* comment, expected `//` comments only"},
    {"{a: 1}", "1:2 /: a key stands in double quotes: \"a\""},
    {"{'a': 1}", "1:2 /: keys and texts stand in double quotes: \"...\""},
    {"{\"a\": paper-1}", "1:7 /: a text stands in double quotes: \"paper-1\""},
    {"{\"a\" 1}", "1:5 /: a `:` is missing behind the key"},
    {"{\"a\" = 1}", "1:6 /: a `:` stands between a key and its value, not `=`"},
    {"{\"a\": 1; \"b\": 2}", "1:8 /: `,` stands between two entries, not `;`"},
    {"{\"a\": }", "1:7 /: a value is missing here"},
    {"{\"a\": , \"b\": 1}", "1:7 /: a value is missing here"},
    {"[1,,2]", "1:4 /: a value is missing here"},
    {"{\"a\": True}", "1:7 /: `True`: JSON writes true"},
    {"{\"a\": None}", "1:7 /: `None`: JSON writes null"},
    {"{\"a\": NaN}", "1:7 /: `NaN` is no number that a file can hold"},
    {"{\"a\": .5}", "1:7 /: `.5`: a number begins with a digit"},
    {"{\"a\": +5}", "1:7 /: `+5`: a number begins with a digit"},
    {"{\"a\": 5.}", "1:7 /: `5.`: a digit is missing behind the point"},
    {"{\"a\": 007}", "1:7 /: `007`: a number does not begin with 0"},
    {"{\"a\": \"x}\n",
     "1:7 /: the text that begins here is not closed in its line: a `\"` is missing"},
    {"{\"a\": \"x", "1:7 /: the text that begins here is not closed: a `\"` is missing"},
    {"{\"a\": \"C:\\x\"}", "1:10 /: `\\` begins an escape; a backslash itself is written `\\\\`"},
    {"{\"a\": [1, 2}",
     "1:12 /a: a `]` is missing before this `}`: the list that begins in line 1 is not closed"},
    {"[{\"a\": 1]",
     "1:9 /0: a `}` is missing before this `]`: the object that begins in line 1 is not closed"},
    {"{\"a\": [1, 2,\n\"b\": 3}",
     "2:1 /a: a `]` is missing before this key: the list that begins in line 1 is not closed"},
    {"{\"a\": [1, 2\n,\"b\": 3}",
     "2:2 /a: a `]` is missing before this key: the list that begins in line 1 is not closed"},
    {"{\u201Ca\u201D: 1}",
     "1:2 /: `\u201C` is no quote of JSON: keys and texts stand in straight double quotes: "
     "\"...\""},
    {"{\"a\u201D: 1,\n\"b\": 2}", "1:4 /: `\u201D` does not close a text: the straight `\"` does"},
    {"{\u00A0\"a\": 1}",
     "1:2 /: a blank that must not be broken (U+00A0), expected an ordinary one"},
    {"{\"a\": \"gr\xFCn\"}",
     "1:10 /: the byte \\xfc is not UTF-8 (in Latin-1 and Windows-1252 it is `\u00FC`): save the "
     "file as UTF-8"},
    {"{} // \x80", "1:7 /: the byte \\x80 is not UTF-8: save the file as UTF-8"},
    {"{\"a\": {\n\"b\": 1\n",
     "2:7 /a: the file ends, but the object that begins in line 1 is not "
     "closed: a `}` is missing"},
    {"[1, 2",
     "1:6 /: the file ends, but the list that begins in line 1 is not closed: a `]` is missing"},
    {"{\"a\": [1, 1e999]}", "1:11 /a: `1e999` is beyond the largest number, 1.8e308"},
    {"{\"a\": -2e400}", "1:7 /: `-2e400` is beyond the largest number, 1.8e308"},
    {"{\"a\": \u22121}", "1:7 /: `\u2212` is no minus sign of JSON: the `-` of the keyboard is"},
    {"{\"a\": \u20131}", "1:7 /: `\u2013` is no minus sign of JSON: the `-` of the keyboard is"},
    {"{\"count\": $cycles}", "1:11 /: a reference stands in double quotes: \"$cycles\""},
    {"\xFF\xFE\x9D\x3A\x77\x12\xC4\x01\x51\xE8",
     "1:1 /: this is no text file, expected an object of JSON: { ... }"},
    {"{} {}", "1:4 /: something follows the end of the file's object"},
    {"{\"a\": 1}}", "1:9 /: something follows the end of the file's object"},
    {"\xEF\xBB\xBF{\"\u00fc\": 1,}", "1:8 /: a `,` behind the last entry: remove it"},
};

TEST(JsonMistake, IsSaidAsAPersonWouldSayIt) {
  for (const Case& c : kMistakes) {
    const auto parsed = JsonDocument::parse(c.text, "f.json");
    ASSERT_FALSE(parsed) << c.text;
    EXPECT_EQ(parsed.error().what, std::string("f.json:") + c.message) << c.text;
  }
}

TEST(JsonMistake, TheDetailShowsTheLineAndThePlace) {
  const auto parsed = JsonDocument::parse("{\n  \"force_N\": 1,5\n}", "f.json");
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().detail,
            "  \"force_N\": 1,5\n             ^\n"
            "the first of possibly several: what follows it was not read");
}

TEST(JsonMistake, InTheLastLineNothingIsLeftToRead) {
  const auto parsed = JsonDocument::parse("{\n  \"force_N\": 1,5 }\n\n", "f.json");
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().detail, "  \"force_N\": 1,5 }\n             ^");
}

TEST(JsonMistake, Utf16IsNamedAndShown) {
  using namespace std::string_literals;
  for (const auto& text : {"\xFF\xFE{\0 \0\"\0a\0"s, "\xFE\xFF\0{\0 \0\"\0a"s, "{\0 \0\"\0a\0"s}) {
    const auto parsed = JsonDocument::parse(text, "f.json");
    ASSERT_FALSE(parsed);
    EXPECT_EQ(parsed.error().what, "f.json:1:1 /: the file is UTF-16: save it as UTF-8");
    EXPECT_EQ(parsed.error().detail, "{ \"a\n^");
  }
}

TEST(JsonMistake, ALongLineIsCutAroundThePlace) {
  const std::string text = "[" + std::string(500, ' ') + "1 2" + std::string(500, ' ') + "]";
  const auto parsed = JsonDocument::parse(text, "f.json");
  ASSERT_FALSE(parsed);
  const std::string& detail = parsed.error().detail;
  EXPECT_LT(detail.size(), 160U);
  const std::size_t caret = detail.find('^') - detail.find('\n') - 1;
  EXPECT_EQ(detail.substr(caret - 1, 3), "1 2");
}

// What the parser accepts is not called a mistake.
TEST(JsonMistake, AGoodTextHasNone) {
  for (const char* text :
       {"{}", "[]", "1", "\"a\"", "{\"a\": [1, -2.5e-3, true, null, \"\\u00fc\\\\\"]} // end",
        "{\"a\": {\"b\": [[], {}]}, \"c\": 0}", "[1e-999, 1e308]"}) {
    EXPECT_TRUE(JsonDocument::parse(text, "f.json")) << text;
    EXPECT_FALSE(find_json_mistake(text)) << text;
  }
}

TEST(JsonReader, TheTenthItemIsNoPartOfTheFirst) {
  const auto document = JsonDocument::parse("[0,\"a\",2,3,4,5,6,7,8,9,\"b\"]", "f.json");
  ASSERT_TRUE(document);
  const JsonReader root(*document);
  for (const JsonReader& item : root.items(1, 20)) item.number();
  const auto result = root.result();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().what, "f.json:1:4 /1: \"a\", expected a number");
  EXPECT_NE(result.error().detail.find(" /10: \"b\", expected a number"), std::string::npos);
}

TEST(JsonReader, TellsAllWrongValuesOfAFile) {
  const auto document =
      JsonDocument::parse("{\"a\": \"x\",\n\"b\": {\"c\": -1, \"d\": true},\n\"e\": 1}", "f.json");
  ASSERT_TRUE(document);
  const JsonReader root(*document);
  root.number("a");
  const auto b = root.object("b");
  b.number("c", kPositive);
  b.number("d");
  b.refuse("judged from values that are wrong");  // says nothing more
  root.no_other_keys();
  const auto result = root.result();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().what, "f.json:1:7 /a: \"x\", expected a number");
  EXPECT_EQ(result.error().detail,
            "{\"a\": \"x\",\n      ^\n"
            "f.json:2:12 /b/c: -1, expected greater than 0\n"
            "\"b\": {\"c\": -1, \"d\": true},\n           ^\n"
            "f.json:2:21 /b/d: true, expected a number\n"
            "\"b\": {\"c\": -1, \"d\": true},\n                    ^\n"
            "f.json:3:1 /e: unknown key `e`, expected a, b\n\"e\": 1}\n^");
}

std::vector<std::string> lines_of(const Error& error) {
  std::vector<std::string> out{error.what};
  std::istringstream in(error.detail);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("f.json:")) out.push_back(line);
  }
  return out;
}

Error error_of(const char* text, const std::function<void(const JsonReader&)>& read) {
  const auto document = JsonDocument::parse(text, "f.json");
  EXPECT_TRUE(document) << text;
  const JsonReader root(*document);
  read(root);
  const auto result = root.result();
  return result ? Error() : result.error();
}

TEST(JsonReader, WhatIsMissingIsSaidOnceForEachKey) {
  const auto error = error_of(R"({"b": {}, "x": 1})", [](const JsonReader& root) {
    root.string("name");
    root.object("other").string("inside");
    root.object("b").number("deep");
    root.quantity("force", Dimension::force);
    root.no_other_keys();
  });
  EXPECT_THAT(lines_of(error),
              ElementsAre("f.json:1:1 /: the key `name` is missing, found b, x",
                          "f.json:1:1 /: the key `other` is missing, found b, x",
                          "f.json:1:1 /: `force` with a unit of force (_mN, _N, _kN) is missing, "
                          "found b, x",
                          "f.json:1:7 /b: the key `deep` is missing",
                          "f.json:1:11 /x: unknown key `x`, expected name, other, b, "
                          "force_(mN|N|kN)"));
}

TEST(JsonReader, AMistypedKeyThatIsMissingIsOneMistake) {
  const auto error =
      error_of(R"({"namex": 1, "forse_N": 2, "sub": {"timex": 1}})", [](const JsonReader& root) {
        root.string("name");
        root.quantity("force", Dimension::force);
        const auto sub = root.object("sub");
        sub.number("time");
        sub.no_other_keys();
        root.no_other_keys();
      });
  EXPECT_THAT(
      lines_of(error),
      ElementsAre("f.json:1:2 /namex: unknown key `namex`, did you mean `name`? It is missing",
                  "f.json:1:14 /forse_N: unknown key `forse_N`, did you mean `force_N`? It "
                  "is missing",
                  "f.json:1:36 /sub/timex: unknown key `timex`, did you mean `time`? It is "
                  "missing"));
}

TEST(JsonReader, OfAFileOfAnotherFormatNothingElseIsSaid) {
  const auto error = error_of(R"({"format": "bench/1", "x": 1})", [](const JsonReader& root) {
    root.expect_format("specimen/1");
    root.string("name");
    root.no_other_keys();
  });
  EXPECT_THAT(lines_of(error),
              ElementsAre("f.json:1:12 /format: \"bench/1\", expected \"specimen/1\""));
}

TEST(JsonReader, OneThatIsWrongLeavesItsNeighboursSound) {
  static_cast<void>(error_of(R"({"a": {"b": "x"}, "c": 1})", [](const JsonReader& root) {
    root.object("a").number("b");
    EXPECT_FALSE(root.sound());
    EXPECT_FALSE(root.at("a").sound());
    EXPECT_TRUE(root.at("c").sound());
  }));
}

}  // namespace
}  // namespace lcrig
