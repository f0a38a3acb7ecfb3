// SPDX-License-Identifier: Apache-2.0
// Tables as a person or a spreadsheet writes them are read back, and each cell is broken in turn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "protocols/batch/batch.hpp"
#include "tests/support/corpus.hpp"

namespace lcrig {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::string press_text(const std::string& name, const std::string& parameters) {
  return R"({ "format": "load-protocol/1", "name": ")" + name + R"(",
  "parameters": { )" +
         parameters + R"( },
  "limits": {},
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" } },
  "steps": [ { "id": "record", "do": "record", "for_s": "$for_s" } ], "finally": [] })";
}
constexpr const char* kFor = R"("for_s": { "default": 10, "min": 1, "max": 100 })";

BatchLookup shelf() {
  BatchLookup out;
  out.protocol = [](const std::string& word) -> Result<BatchFile> {
    BatchFile file;
    file.name = word;
    if (word == "press") file.text = press_text(word, kFor);
    if (word == "rub") {
      file.text = press_text(
          word, std::string(kFor) + R"(, "cycles": { "default": 5, "min": 1, "max": 9 })");
    }
    if (file.text.empty()) return fail(Errc::invalid_request, "no protocol `{}`", word);
    return file;
  };
  out.specimen = [](const std::string& word) -> Result<BatchFile> {
    BatchFile file;
    file.name = word;
    file.text = "of " + word;
    if (word.starts_with("paper")) return file;
    return fail(Errc::invalid_request, "no specimen `{}`", word);
  };
  return out;
}

Result<std::vector<BatchEntry>> entries_of(const std::string& text) {
  auto table = read_batch_table(text, "t.csv");
  if (!table) return fail(table.error());
  return check_batch(*table, shelf());
}
// The message with everything below it. Empty: nothing is wrong.
std::string refusal_of(const std::string& text) {
  const auto got = entries_of(text);
  return got ? std::string() : got.error().what + "\n" + got.error().detail;
}
std::size_t mistakes_in(const std::string& refusal) {
  std::size_t count = 0;
  for (auto at = refusal.find("t.csv:"); at != refusal.npos; at = refusal.find("t.csv:", at + 1)) {
    ++count;
  }
  return count;
}

TEST(BatchTable, IsReadAsSpreadsheetsWriteIt) {
  const std::vector<std::string> forms{
      "specimen,protocol,repeats,for_s,note\npaper-1,press,3,2.5,\"say \"\"a\"\", b\"\n",
      "\xEF\xBB\xBFspecimen;protocol;repeats;for_s;note\r\npaper-1;press;3;2.5;\"say \"\"a\"\", "
      "b\"\r\n",
      "specimen\tprotocol\trepeats\tfor_s\tnote\npaper-1\tpress\t3\t2.5\t\"say \"\"a\"\", b\"",
      "\r\n specimen , protocol,repeats,for_s,note\r\n\r\n paper-1 , press,3, 2.5 ,\"say "
      "\"\"a\"\", b\" \r\n,,,,\r\n",
      R"({ "format": "batch/1", "runs": [ { "specimen": "paper-1", "protocol": "press", "repeats": 3,
          "parameters": { "for_s": 2.5 }, "note": "say \"a\", b" } ] })"};
  for (const auto& text : forms) {
    const auto got = entries_of(text);
    ASSERT_TRUE(got) << text << "\n" << got.error().what << got.error().detail;
    ASSERT_EQ(got->size(), 1U) << text;
    const BatchEntry& entry = got->front();
    EXPECT_EQ(entry.specimen_name, "paper-1");
    EXPECT_EQ(entry.protocol_name, "press");
    EXPECT_EQ(entry.repeats, 3);
    EXPECT_EQ(entry.note, "say \"a\", b");
    EXPECT_EQ(entry.parameters.size(), 1U);
    EXPECT_EQ(std::get<std::string>(entry.parameters.at("for_s")), "2.5");
  }
}

TEST(BatchTable, TermsAndSettingsOfTheMeterAreColumnsToo) {
  const auto got = entries_of(
      "specimen,protocol,parameters,on_failure,unattended,rest_s,frequency_Hz\n"
      "paper-1,rub,cycles=3 for_s=7,skip,yes,60,2000\npaper-1,press,,,,,\n");
  ASSERT_TRUE(got) << got.error().what;
  const BatchEntry& entry = got->front();
  EXPECT_EQ(entry.parameters.size(), 2U) << "the frequency went into the text of the protocol";
  EXPECT_THAT(entry.protocol_text, HasSubstr("2000"));
  EXPECT_EQ(entry.terms.on_failure, OnFailure::skip);
  EXPECT_EQ(entry.terms.unattended, true);
  EXPECT_EQ(entry.terms.rest_s, 60.0);
  EXPECT_FALSE((*got)[1].terms.on_failure || (*got)[1].terms.unattended || (*got)[1].terms.rest_s);
}

TEST(BatchTable, SaysWhatIsWrongInWords) {
  const std::string head = "specimen,protocol,repeats,for_s\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "t.csv:1:1: the file is empty"},
      {"\n\n", "the file is empty"},
      {head, "a header and no row"},
      {"specimen,protocol,specimen\npaper-1,press,paper-1\n",
       "t.csv:1:19 specimen: columns 1 and 3"},
      {"specimen,,protocol\npaper-1,,press\n", "t.csv:1:10: column 2 of the header has no name"},
      {"specimen,protokoll\npaper-1,press\n", "no column `protocol`; is it `protokoll`?"},
      {"specimen,protocol,repeat\npaper-1,press,2\n", "did you mean `repeats`?"},
      {head + "paper-1,press,2\n", "t.csv:2:15: the row has 3 cells, the header has 4"},
      {head + "paper-1,press,2,0,5\n", "decimal numbers are written with a point"},
      {"specimen;protocol;for_s\npaper-1;press;2,5\n", "t.csv:2:15 for_s: "},
      {"specimen;protocol;for_s\npaper-1;press;2,5\n", "with a point: 2.5"},
      {head + "paper-1,press,1.5,\n", "t.csv:2:15 repeats: \"1.5\", expected a whole number"},
      {head + "paper-1,press,0,\n", "expected a whole number from 1"},
      {head + "paper-1,\"press,1,2\n", "t.csv:2:9: the quote that begins here has no end"},
      {head + "paper-1,pr\"ess,1,2\n", "t.csv:2:11: a quote inside a cell"},
      {head + "paper-1,\"press\"x,1,2\n", "t.csv:2:16: text behind the quote"},
      {head + "paper-1,press,1,2\nsp\xE4t,press,1,2\n", "t.csv:3:3: "},
      {head + "paper-1,press,1,1000\n", "t.csv:2:17 for_s: "},
      {head + "nobody,press,1,\n", "t.csv:2:1 specimen: no specimen `nobody`"},
      {head + ",press,1,\n", "t.csv:2:1 specimen: is empty"},
      {head + "paper-1,,1,\n", "t.csv:2:9 protocol: is empty"},
      {"specimen,protocol,parameters\npaper-1,press,for_s\n", "expected NAME=VALUE"},
      {"specimen,protocol,parameters,for_s\npaper-1,press,for_s=2,3\n", "two values in this row"},
      {"specimen,protocol,cycles\npaper-1,press,2\npaper-1,rub,2\n",
       "t.csv:2:15 cycles: press has no"},
      {"specimen,protocol,repeats\npaper-1,press,9000\npaper-1,press,9000\n",
       "more than 10000 runs"},
      {"specimen,protocol,unattended\npaper-1,press,maybe\n", "expected yes or no"},
      {"specimen,protocol,frequency_Hz\npaper-1,press,1kHz\n", "t.csv:2:15 frequency_Hz: "},
      {R"({ "format": "batch/1", "runs": [ { "specimen": "paper-1", "protocol": "press",
 "parameters": { "for_s": 1000 } } ] })",
       "t.csv:2:27 for_s: "},
      {R"({ "format": "batch/1", "runs": [ { "protocol": "press" } ] })", "specimen"},
      {R"({ "format": "batch/1", "runs": [] })", "/runs"}};
  for (const auto& [text, words] : cases) EXPECT_THAT(refusal_of(text), HasSubstr(words)) << text;
}

TEST(BatchTable, SaysAllAtOnceAndEachOnce) {
  const std::string refusal = refusal_of(
      "specimen,protocol,repeats,speed\nnobody,press,1,\npaper-1,none,1,\npaper-1,press,x,7\n");
  EXPECT_EQ(mistakes_in(refusal), 4U) << refusal;
  EXPECT_THAT(refusal, AllOf(HasSubstr("t.csv:2:1 specimen"), HasSubstr("t.csv:3:9 protocol"),
                             HasSubstr("t.csv:4:15 repeats"), HasSubstr("t.csv:4:17 speed")));
  std::string many = "specimen,protocol\n";
  for (int i = 0; i < 30; ++i) many += "nobody,press\n";
  EXPECT_THAT(refusal_of(many), HasSubstr("... and 10 more"));
}

TEST(BatchTable, OfTenThousandRowsItReadsAllAndOfMoreNone) {
  std::string text = "specimen,protocol\n";
  for (std::size_t i = 0; i < 10'000; ++i) text += "paper-1,press\n";
  const auto got = entries_of(text);
  ASSERT_TRUE(got) << got.error().what;
  EXPECT_EQ(got->size(), 10'000U);
  EXPECT_THAT(refusal_of(text + "paper-1,press\n"), HasSubstr("more than 10000 rows"));
  EXPECT_THAT(refusal_of("specimen,protocol\n" + std::string(2'000'000, 'x')), HasSubstr("split"));
}

TEST(BatchCorpus, SchemaAndReaderAcceptAndRefuseTheSame) {
  corpus::expect_all_refused("tests/corpus/batch/reject", 12, read_batch_table);
  for (const auto& path : corpus::files("tests/corpus/batch/accept")) {
    const auto read = read_batch_table(read_text_file(path).value(), path.string());
    EXPECT_TRUE(read) << read.error().what;
  }
}

// A table: its cells as they should be read, and its text.
struct DrawnTable {
  std::vector<std::vector<std::string>> cells;  // the header first
  char separator = ',';
  std::string line_end = "\n";

  std::string text() const {
    std::string out;
    for (const auto& row : cells) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (i > 0) out += separator;
        out += written(row[i]);
      }
      out += line_end;
    }
    return out;
  }
  std::string written(const std::string& cell) const {
    const bool plain = cell.find_first_of("\",;\t\r\n") == cell.npos &&
                       (cell.empty() || (cell.front() != ' ' && cell.back() != ' '));
    if (plain) return cell;
    std::string out = "\"";
    for (const char c : cell) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
  }
};

class Drawer {
 public:
  explicit Drawer(std::uint64_t seed) : random_(seed) {}
  std::size_t below(std::size_t n) { return random_() % n; }
  DrawnTable table() {
    DrawnTable out;
    out.separator = ",;\t"[below(3)];
    out.line_end = below(2) == 0 ? "\n" : "\r\n";
    out.cells.push_back({"specimen", "protocol", "repeats", "for_s", "cycles", "rest_s", "note"});
    std::ranges::shuffle(out.cells.front(), random_);
    const std::size_t rows = 1 + below(8);
    for (std::size_t i = 0; i < rows; ++i) out.cells.push_back(row(out.cells.front()));
    return out;
  }

 private:
  std::vector<std::string> row(const std::vector<std::string>& heads) {
    const bool rubs = below(2) == 0;
    std::vector<std::string> out;
    for (const auto& head : heads) {
      std::string cell;
      if (head == "specimen") cell = "paper-" + std::to_string(1 + below(3));
      if (head == "protocol") cell = rubs ? "rub" : "press";
      if (head == "repeats" && below(2) == 0) cell = std::to_string(1 + below(4));
      if (head == "for_s" && below(2) == 0) cell = std::to_string(1 + below(100));
      if (head == "cycles" && rubs) cell = std::to_string(1 + below(9));
      if (head == "rest_s" && below(3) == 0) cell = "0.5";
      if (head == "note") cell = note();
      out.push_back(cell);
    }
    return out;
  }
  std::string note() {
    static const std::vector<std::string> kPieces{"a",  "\"", ",",   ";", "\t",
                                                  "\n", "µm", "x y", "'"};
    std::string out;
    for (std::size_t i = below(6); i > 0; --i) out += kPieces[below(kPieces.size())];
    return out.empty() ? out : "n" + out + "n";
  }
  std::mt19937_64 random_;
};

TEST(BatchTable, RandomTablesComeBackAsTheyWereWritten) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const DrawnTable drawn = Drawer(seed).table();
    const auto table = read_batch_table(drawn.text(), "t.csv");
    ASSERT_TRUE(table) << drawn.text() << table.error().what;
    ASSERT_EQ(table->rows.size() + 1, drawn.cells.size()) << drawn.text();
    for (std::size_t r = 0; r < table->rows.size(); ++r) {
      for (std::size_t c = 0; c < table->columns.size(); ++c) {
        ASSERT_EQ(table->columns[c].name, drawn.cells[0][c]);
        ASSERT_EQ(table->rows[r].cells[c].text, drawn.cells[r + 1][c]) << drawn.text();
      }
    }
    EXPECT_EQ(refusal_of(drawn.text()), "") << drawn.text();
  }
}

// The place where the cell begins, by counting characters of its line: a second way to find it.
TextPosition where_written(const DrawnTable& drawn, std::size_t row, std::size_t column) {
  DrawnTable before = drawn;
  before.cells.resize(row + 1);
  before.cells[row].resize(column + 1);
  std::string text = before.text();
  text.resize(text.size() - drawn.line_end.size() - drawn.written(drawn.cells[row][column]).size());
  TextPosition at;
  at.line += static_cast<int>(std::ranges::count(text, '\n'));
  const auto line = text.substr(text.rfind('\n') == text.npos ? 0 : text.rfind('\n') + 1);
  for (const char c : line) at.column += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U ? 1 : 0;
  return at;
}

TEST(BatchTable, EachCellBrokenInTurnGivesOneMessageWithItsPlace) {
  int broken = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const DrawnTable good = Drawer(seed).table();
    for (std::size_t r = 1; r < good.cells.size(); ++r) {
      for (std::size_t c = 0; c < good.cells[0].size(); ++c) {
        const std::string& column = good.cells[0][c];
        const bool rubs = std::ranges::any_of(
            good.cells, [](const auto& row) { return std::ranges::find(row, "rub") != row.end(); });
        // A column that no protocol of the table knows is refused in its header.
        if (column == "note" || (column == "cycles" && !rubs)) continue;
        DrawnTable bad = good;
        bad.cells[r][c] = column == "repeats" ? "many" : "-7.x";
        const auto at = where_written(bad, r, c);
        const std::string refusal = refusal_of(bad.text());
        EXPECT_EQ(mistakes_in(refusal), 1U) << bad.text() << refusal;
        EXPECT_THAT(refusal, HasSubstr(fmt::format("t.csv:{}:{} {}: ", at.line, at.column, column)))
            << bad.text();
        ++broken;
      }
    }
  }
  EXPECT_GT(broken, 500);
}

std::vector<BatchEntry> rows_of(const std::vector<std::pair<std::string, int>>& specimens) {
  std::vector<BatchEntry> out;
  for (const auto& [name, repeats] : specimens) {
    BatchEntry entry;
    entry.specimen_name = name;
    entry.repeats = repeats;
    out.push_back(entry);
  }
  return out;
}

TEST(BatchOrderOfRuns, IsThatOfTheTableOrOfTheSeed) {
  const auto rows = rows_of({{"a", 2}, {"b", 1}, {"a", 3}});
  using T = BatchTurn;
  EXPECT_THAT(order_batch(rows, BatchOrder::given, 5),
              ElementsAre(T{0, 1}, T{0, 2}, T{1, 1}, T{2, 1}, T{2, 2}, T{2, 3}));
  // The order is fixed: another computer or another library gives the same.
  EXPECT_EQ(order_batch(rows, BatchOrder::random, 5), order_batch(rows, BatchOrder::random, 5));
  std::set<std::string> seen;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    std::string word;
    for (const T& turn : order_batch(rows, BatchOrder::random, seed)) {
      word += fmt::format("{}.{} ", turn.row, turn.repeat);
    }
    seen.insert(word);
  }
  EXPECT_GT(seen.size(), 150U) << "of 720";
}

TEST(BatchOrderOfRuns, InBlocksChangesTheSpecimenAsSeldomAsCanBe) {
  const auto rows = rows_of({{"a", 4}, {"b", 4}, {"a", 4}});
  std::set<std::string> seen;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::string specimens, order;
    for (const auto& turn : order_batch(rows, BatchOrder::blocks, seed)) {
      specimens += rows[turn.row].specimen_name;
      order += fmt::format("{}.{} ", turn.row, turn.repeat);
    }
    EXPECT_EQ(specimens, "aaaaaaaabbbb");
    seen.insert(order);
  }
  EXPECT_GT(seen.size(), 15U);
}

TEST(BatchOrderOfRuns, EveryPlaceIsEquallyLikely) {
  const auto rows = rows_of({{"a", 4}});
  std::vector<int> first(5);
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const auto order = order_batch(rows, BatchOrder::random, seed);
    ++first[static_cast<std::size_t>(order.front().repeat)];
  }
  for (std::size_t repeat : {1U, 2U, 3U, 4U}) EXPECT_NEAR(first[repeat], 1000, 110);
}

}  // namespace
}  // namespace lcrig
