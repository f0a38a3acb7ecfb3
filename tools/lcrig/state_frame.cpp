// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/state_frame.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "base/number.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "base/text_place.hpp"
#include "base/whole_file.hpp"
#include "daemon/control/config_view.hpp"
#include "tools/lcrig/command_output.hpp"

namespace lcrig::cli {

namespace {

constexpr std::string_view kLoop = "force_loop.";

struct Question {
  const char* group;  // the key in InstrumentState::unstated; nullptr: it is not asked for
  const char* key;
  const char* words;
};

// lint: table
constexpr Question kQuestions[] = {
    {"frame.travel_step_um", "travel_step_um", "step in which its samples show travel, um"},
    {"frame.force_loop", "force_loop.approach_mm_s",
     "force control: fastest speed before contact, mm/s"},
    {"frame.force_loop", "force_loop.contact_N", "force control: force that counts as contact, N"},
    {"frame.force_loop", "force_loop.rate_max_N_s", "force control: fastest force rate, N/s"},
    {"frame.force_loop", "force_loop.lag_s",
     "force control: overshoot of a ramp over its rate, at most, s"},
    {"frame.force_loop", "force_loop.ripple_N",
     "force control: a held force stays within this, to either side, N"},
    {"frame.force_loop", "force_loop.stiffness_max_N_mm",
     "force control: stiffest contact for which the others hold, N/mm"},
    {nullptr, "force_class", ""},
    {nullptr, "force_step_mN", ""},
    {nullptr, "filter_s", ""},
    {nullptr, "play_um", ""},
};

std::string known_keys() {
  std::string out;
  for (const Question& q : kQuestions) out += (out.empty() ? "" : ", ") + std::string(q.key);
  return out;
}

std::string line_of(std::string_view key, double value) {
  return fmt::format("\"{}\": {},", key, value);
}

// nullopt: left out.
std::optional<double> ask_for(Console& console, const Question& q) {
  for (;;) {
    const auto line = console.wait_for_line(fmt::format("{} ({}): ", q.words, q.key));
    if (!line || line->empty()) return std::nullopt;
    const auto value = number_from<double>(*line);
    if (value && *value >= 0) return value;
    console.note(printable(*line, kLongestName) + ": expected a number from 0 on, or Enter");
  }
}

// All values of a group or none: some of a force loop without the others bound nothing.
FrameStatements ask_for_group(Console& console, std::string_view group) {
  FrameStatements out;
  for (const Question& q : kQuestions) {
    if (q.group == nullptr || q.group != group) continue;
    const auto value = ask_for(console, q);
    if (!value) return {};
    out.emplace_back(q.key, *value);
  }
  return out;
}

// Keeps owner and rights of the file that it replaces.
Result<> replace_file(PartFile& part, const std::string& path, std::string_view text) {
  struct ::stat old{};
  if (auto good = write_text(part.fd(), part.name(), text); !good) return good;
  if (::stat(path.c_str(), &old) != 0 || ::fchown(part.fd(), old.st_uid, old.st_gid) != 0 ||
      ::fchmod(part.fd(), old.st_mode & 07777U) != 0) {
    return fail(Errc::io, "{}: owner and rights cannot be kept", path);
  }
  return {};
}

// Failure: the text cannot be changed, the changed file is wrong, or it cannot be written.
Outcome<std::string> write_statements(const Context& context, const std::string& file,
                                      std::string_view lines) {
  std::error_code unknown;
  const auto path = std::filesystem::canonical(file, unknown).string();
  auto text = read_text_file(path);
  if (!text) return Failure(text.error());
  auto changed = with_lines(*text, file, lines);
  if (!changed) return changed;
  auto part = PartFile::create(path);
  if (!part) return Failure(part.error());
  if (auto good = replace_file(*part, path, *changed); !good) return Failure(good.error());
  if (auto view = context.daemon.config(part->name()); !view) return Failure(view.error());
  if (auto good = part->replace(); !good) return Failure(good.error());
  return changed;
}

}  // namespace

Outcome<FrameStatements> parse_statements(const std::vector<std::string>& words) {
  FrameStatements out;
  for (const std::string& word : words) {
    const auto assigned = split_assignment(word);
    const auto value = assigned ? number_from<double>(assigned->second) : std::nullopt;
    const auto known = [&](const Question& q) { return assigned->first == q.key; };
    if (!assigned || std::ranges::none_of(kQuestions, known)) {
      return Failure(kUsage,
                     fmt::format("--state {}: expected KEY=VALUE; the keys are {}", printable(word),
                                 known_keys()),
                     "lcrig doctor --help");
    }
    if (!value || *value < 0) {
      return Failure(kUsage,
                     fmt::format("--state {}: expected a number from 0 on", printable(word)),
                     "lcrig doctor --help");
    }
    out.emplace_back(assigned->first, *value);
  }
  return out;
}

FrameStatements ask_for_statements(Console& console, const std::vector<std::string>& unstated) {
  FrameStatements out;
  if (unstated.empty()) return out;
  console.note(
      "the frame does not state all that a run may need, and nothing is guessed: state it once, "
      "from its manual or a measurement; Enter leaves it out");
  for (const std::string& group : unstated) {
    const auto answers = ask_for_group(console, group);
    out.insert(out.end(), answers.begin(), answers.end());
  }
  return out;
}

Outcome<std::string> lines_of(const FrameStatements& statements) {
  std::string out, loop;
  for (const Question& q : kQuestions) {
    const std::string_view key = q.key;
    const auto given = std::ranges::find(statements, key, &FrameStatement::key);
    const bool of_loop = key.starts_with(kLoop);
    if (given == statements.end()) continue;
    std::string& into = of_loop ? loop : out;
    into +=
        (into.empty() ? "" : " ") + line_of(of_loop ? key.substr(kLoop.size()) : key, given->value);
  }
  if (loop.empty()) return out;
  for (const Question& q : kQuestions) {
    const std::string_view key = q.key;
    if (!key.starts_with(kLoop) ||
        std::ranges::find(statements, key, &FrameStatement::key) != statements.end()) {
      continue;
    }
    return Failure(kUsage,
                   fmt::format("{} is missing: some values of a force loop without the others "
                               "bound nothing",
                               key),
                   fmt::format("lcrig doctor --state {}=VALUE, with the others", key));
  }
  loop.pop_back();  // the last comma
  return out + (out.empty() ? "" : " ") + "\"force_loop\": { " + loop + " },";
}

Outcome<std::string> with_lines(std::string_view text, const std::string& name,
                                std::string_view lines) {
  auto document = JsonDocument::parse(text, name);
  if (!document) return Failure(document.error());
  const auto frame = JsonReader(*document).find("frame");
  if (!frame || !frame->is_object()) {
    return Failure(kFailed, fmt::format("{}: there is no `frame` in it", name),
                   "lcrig config check " + shell_quoted(name));
  }
  std::string out(text);
  const auto brace = byte_of(text, document->value_position("/frame"));
  return out.insert(brace + 1, fmt::format(" {}", lines));
}

std::vector<std::string> without_stated(const Context& context, const std::string& file,
                                        std::vector<std::string> unstated) {
  const auto view = context.daemon.config(file);
  if (!view) return unstated;
  std::erase_if(unstated, [&](const std::string& key) {
    return std::ranges::any_of(view->keys, [&](const ConfigKeyView& k) {
      const bool names_it = k.key == key || k.key.starts_with(key + ".");
      return names_it && !std::holds_alternative<std::monostate>(k.value);
    });
  });
  return unstated;
}

Finding state_in_file(const Context& context, const std::string& file,
                      const FrameStatements& statements) {
  const auto lines = lines_of(statements);
  if (!lines) return {"frame's facts", Health::warn, lines.error().what, lines.error().next};
  auto written = write_statements(context, file, *lines);
  if (written) {
    return {"frame's facts", Health::ok,
            fmt::format("written into {}: {}", printable(file), *lines),
            "sudo systemctl reload lcrigd"};
  }
  return {"frame's facts", Health::warn,
          "not written: " + printable(written.error().what, kLongestWords),
          fmt::format("add to \"frame\" in {}: {}", printable(file), *lines)};
}

}  // namespace lcrig::cli
