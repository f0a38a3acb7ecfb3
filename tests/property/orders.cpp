// SPDX-License-Identifier: Apache-2.0
#include "tests/property/orders.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace lcrig::property {

namespace {

using Seen = RigWitness::Seen;
using Word = RigWitness::Word;

std::optional<double> field(const std::string& line, const std::string& key) {
  const auto at = line.find(" " + key + "=");
  if (at == line.npos) return std::nullopt;
  double value = 0;
  const char* from = line.data() + at + key.size() + 2;
  const auto r = std::from_chars(from, line.data() + line.size(), value);
  return r.ec == std::errc() ? std::optional(value) : std::nullopt;
}

std::int64_t number_in(const std::string& line) {
  const auto at = line.find('#');
  std::int64_t n = -1;
  if (at != line.npos) std::from_chars(line.data() + at + 1, line.data() + line.size(), n);
  return n;
}

// The last travel shown before an instant.
std::optional<double> shown_m(const RigWitness& w, MonoTime before) {
  std::optional<double> out;
  for (const Seen& s : w.seen) {
    if (s.taken > before) break;
    if (s.shown.travel_m) out = s.shown.travel_m;
  }
  return out;
}

Ordered parse_order(const Word& word, const RigWitness& w) {
  Ordered o;
  o.number = number_in(word.line);
  const auto blank = word.line.find(' ');
  o.word = word.line.substr(blank + 1, word.line.find(' ', blank + 1) - blank - 1);
  o.sent = word.at;
  o.over = MonoTime::max();
  const auto travel = field(word.line, "travel_mm"), speed = field(word.line, "speed_mm_s");
  if (travel) o.travel_m = *travel * 1e-3;
  o.force_N = field(word.line, "force_N");
  o.speed_m_s = std::abs(speed.value_or(0)) * 1e-3;
  o.rate_N_s = field(word.line, "rate_N_s").value_or(0);
  o.from_m = shown_m(w, word.at).value_or(0);
  if (o.word == "MOVE" && o.travel_m) o.direction = *o.travel_m > o.from_m ? 1 : -1;
  if (o.word == "MOVEF") o.direction = speed.value_or(0) > 0 ? 1 : -1;
  return o;
}

bool is_motion(const Word& w) {
  if (!w.is_sent || !w.line.starts_with("#")) return false;
  return w.line.find(" MOVE ") != w.line.npos || w.line.find(" MOVEF ") != w.line.npos ||
         w.line.find(" RAMPF ") != w.line.npos;
}

void end_order(Ordered& o, const Word& w) {
  if (o.over != MonoTime::max() || w.at < o.sent) return;
  const bool by_us = w.is_sent && (w.line == "STOP" || w.line.starts_with("HELLO"));
  const bool told = !w.is_sent && number_in(w.line) == o.number &&
                    (w.line.starts_with("DONE") || w.line.starts_with("ERR"));
  if (!by_us && !told) return;
  o.over = w.at;
  o.is_limited = told && w.line.find("reason=\"force_limit\"") != w.line.npos;
  o.is_stopped = by_us && w.line == "STOP";
  o.is_done = told && w.line.find("reason=\"target\"") != w.line.npos;
}

}  // namespace

std::vector<Ordered> ordered_motions(const RigWitness& witness) {
  std::vector<Ordered> out;
  for (const Word& w : witness.words) {
    for (Ordered& o : out) end_order(o, w);
    if (is_motion(w)) out.push_back(parse_order(w, witness));
  }
  return out;
}

std::vector<MonoTime> stops_sent(const RigWitness& witness) {
  std::vector<MonoTime> out;
  for (const Word& w : witness.words) {
    if (w.is_sent && w.line == "STOP") out.push_back(w.at);
  }
  return out;
}

std::optional<PrintedContact> printed_contact(const RigWorld& world, MonoTime before) {
  std::optional<PrintedContact> out;
  double travel_m = 0;
  for (const RunEvent& e : world.events) {
    if (e.t > before) break;
    if (e.kind == EventKind::contact) {
      out.reset();
      travel_m = nlohmann::json::parse(e.detail).at("travel_m");
    }
    if (e.kind == EventKind::zero) out.reset();
    if (e.kind != EventKind::stiffness) continue;
    const auto detail = nlohmann::json::parse(e.detail);
    if (detail.at("at_least_N_m").is_null()) continue;
    out.emplace();
    out->travel_m = travel_m;
    out->stiffness_N_m = detail.at("at_least_N_m");
  }
  return out;
}

double deepest_m(const std::vector<RigWitness::Seen>& seen, MonoTime until) {
  double most = -1e9;
  for (const auto& s : seen) {
    if (s.taken <= until) most = std::max(most, s.shown.travel_m.value_or(most));
  }
  return most;
}

double shown_N(const std::vector<RigWitness::Seen>& seen, MonoTime until) {
  double last = 0;
  for (const auto& s : seen) {
    if (s.taken <= until) last = s.shown.force_N.value_or(last);
  }
  return last;
}

}  // namespace lcrig::property
