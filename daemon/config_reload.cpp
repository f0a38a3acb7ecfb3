// SPDX-License-Identifier: Apache-2.0
#include "daemon/config_reload.hpp"

#include <algorithm>
#include <utility>

#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kShown = 200;  // characters of a value in a message

std::string words_of(const ConfigChange& change, const char* when) {
  return fmt::format("{}: {} -> {}, {}", change.key, printable(to_text(change.from), kShown),
                     printable(to_text(change.to), kShown), when);
}

const char* when_of(const ConfigChange& change, bool idle) {
  switch (change.effect) {
    case ConfigEffect::at_once: return "from now on";
    case ConfigEffect::when_idle:
      return idle ? "from the next run on" : "as soon as the rig is idle";
    case ConfigEffect::restart: break;
  }
  return "needs a restart (systemctl restart lcrigd): until then it stays as it was";
}

}  // namespace

std::vector<std::string> ConfigReload::take(Config wanted, bool idle) {
  refused_.clear();
  const auto changes = changes_of(in_force_, wanted);
  std::vector<std::string> out;
  out.reserve(changes.size());
  for (const auto& change : changes) out.push_back(words_of(change, when_of(change, idle)));
  take_changes(in_force_, wanted, changes, ConfigEffect::at_once);
  if (idle) take_changes(in_force_, wanted, changes, ConfigEffect::when_idle);
  wanted_ = std::move(wanted);
  return out;
}

std::vector<std::string> ConfigReload::take_when_idle() {
  if (!wanted_) return {};
  const auto changes = changes_of(in_force_, *wanted_);
  std::vector<std::string> out;
  for (const auto& change : changes) {
    if (change.effect == ConfigEffect::when_idle) out.push_back(words_of(change, "from now on"));
  }
  take_changes(in_force_, *wanted_, changes, ConfigEffect::when_idle);
  return out;
}

ConfigView ConfigReload::view() const {
  ConfigView out;
  out.file = in_force_.file;
  out.of_daemon = true;
  out.refused = refused_;
  out.keys = keys_of(in_force_);
  if (!wanted_) return out;
  const auto of_file = keys_of(*wanted_);
  for (const auto& change : changes_of(in_force_, *wanted_)) {
    auto key = std::ranges::find(out.keys, change.key, &ConfigKeyView::key);
    if (key == out.keys.end()) {  // a key of the rig that the file now describes
      ConfigKeyView added;
      added.key = change.key;
      key = out.keys.insert(out.keys.end(), std::move(added));
    }
    key->waiting.emplace();
    key->waiting->value = change.to;
    key->waiting->effect = change.effect;
  }
  // A key that was applied may be new in the file, or gone from it.
  for (auto& key : out.keys) {
    const auto now = std::ranges::find(of_file, key.key, &ConfigKeyView::key);
    if (!key.waiting && now != of_file.end()) key.source = now->source;
  }
  return out;
}

}  // namespace lcrig
