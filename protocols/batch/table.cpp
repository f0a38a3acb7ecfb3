// SPDX-License-Identifier: Apache-2.0
#include "protocols/batch/table.hpp"

#include "base/json_mistake.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kBatchBytesMax = 800'000;  // a message to the daemon holds little more

TextPosition place_of_byte(std::string_view text, std::size_t byte) {
  TextPosition at;
  std::size_t begin = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  while (true) {
    const std::size_t next = next_line(text, begin);
    if (next > byte || next >= text.size()) break;
    begin = next;
    ++at.line;
  }
  for (std::string_view rest = text.substr(begin); text.size() - rest.size() < byte;) {
    take_character(rest);
    ++at.column;
  }
  return at;
}

Result<> check_bytes(std::string_view text, const std::string& source) {
  BatchMistakes wrong;
  if (text.size() > kBatchBytesMax) {
    wrong.add(
        TextPosition(), "",
        fmt::format("{} bytes, expected at most {}: split the table", text.size(), kBatchBytesMax));
  } else if (const auto mistake = find_encoding_mistake(text)) {
    wrong.add(place_of_byte(text, mistake->at), "", mistake->words);
  }
  return wrong.result(source, text);
}

}  // namespace

void BatchMistakes::add(TextPosition at, std::string_view where, std::string what) {
  mistakes_.push_back({at, std::string(where), std::move(what)});
}

Result<> BatchMistakes::result(const std::string& source, std::string_view text) const {
  std::vector<TextPosition> places;
  for (const Mistake& m : mistakes_) places.push_back(m.at);
  return refuse_at(text, places, [&](std::size_t i) {
    const Mistake& m = mistakes_[i];
    const auto where = m.where.empty() ? std::string() : " " + printable(m.where, 60);
    return fmt::format("{}:{}:{}{}: {}", source, m.at.line, m.at.column, where,
                       printable(m.what, 2000));
  });
}

Result<BatchTable> read_batch_table(std::string_view text, const std::string& source) {
  if (auto good = check_bytes(text, source); !good) return fail(good.error());
  std::string_view body = text;
  if (body.starts_with(kByteOrderMark)) body.remove_prefix(kByteOrderMark.size());
  if (trimmed(body).starts_with('[')) {
    BatchMistakes wrong;
    wrong.add(TextPosition(), "",
              "a list, expected a JSON object with \"format\": \"batch/1\" and the list as its "
              "\"runs\", or CSV");
    return fail(wrong.result(source, text).error());
  }
  const bool is_json = trimmed(body).starts_with('{') || trimmed(body).starts_with("//");
  auto table = is_json ? read_batch_json(text, source) : read_batch_csv(text, source);
  if (!table) return table;
  table->source = source;
  table->text = std::string(text);
  return table;
}

}  // namespace lcrig
