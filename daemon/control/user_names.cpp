// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/user_names.hpp"

#include "base/aside.hpp"

#include <fmt/format.h>
#include <pwd.h>
#include <spdlog/spdlog.h>

#include <array>
#include <boost/asio/post.hpp>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kFresh = 60s;
// Lookups of different users at the same time. A service that hangs blocks their threads.
constexpr std::size_t kMostUnderWay = 8;

}  // namespace

struct UserNames::Link {
  explicit Link(UserNames* o) : owner(o) {}
  std::mutex mutex;
  UserNames* owner;  // used on the owner's thread; nullptr: the owner is gone, and perhaps its
                     // executor
};

std::string uid_words(std::uint32_t uid) {
  return fmt::format("uid {}", uid);
}

std::optional<std::string> UserNames::of_system(std::uint32_t uid) {
  std::array<char, 4096> buffer{};
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(uid, &entry, buffer.data(), buffer.size(), &found) != 0) return std::nullopt;
  if (found == nullptr) return std::nullopt;
  return found->pw_name;
}

UserNames::UserNames(asio::any_io_executor executor, Clock& clock, Lookup lookup)
    : executor_(std::move(executor)),
      clock_(clock),
      lookup_(std::move(lookup)),
      changed_(clock),
      link_(std::make_shared<Link>(this)) {}

UserNames::~UserNames() {
  const std::lock_guard lock(link_->mutex);
  link_->owner = nullptr;
}

void UserNames::look_up(std::uint32_t uid) {
  const auto old = entries_.find(uid);
  const bool known = old != entries_.end() && old->second.name;
  if (known && clock_.now() - old->second.begun < kFresh) return;
  if (old != entries_.end() && old->second.under_way) return;
  if (under_way_ >= kMostUnderWay) return;
  const auto job = [link = link_, executor = executor_, lookup = lookup_, uid] {
    auto name = lookup(uid);
    const std::lock_guard lock(link->mutex);
    if (link->owner == nullptr) return;
    asio::post(executor, [link, uid, name = std::move(name)] {
      if (link->owner != nullptr) link->owner->learn(uid, name);
    });
  };
  try {
    std::thread(job).detach();
  } catch (const std::system_error& e) {  // no more threads: the uid is shown instead
    spdlog::warn("the name of {} is not looked up: {}", uid_words(uid), e.what());
    return;
  }
  Entry& entry = entries_[uid];
  entry.begun = clock_.now();
  entry.under_way = true;
  ++under_way_;
}

void UserNames::learn(std::uint32_t uid, std::optional<std::string> name) {
  Entry& entry = entries_[uid];
  if (name) entry.name = std::move(name);
  entry.under_way = false;
  --under_way_;
  changed_.notify_all();
}

std::string UserNames::known(std::uint32_t uid) const {
  const auto entry = entries_.find(uid);
  if (entry == entries_.end()) return uid_words(uid);
  return entry->second.name.value_or(uid_words(uid));
}

Task<std::string> UserNames::find(std::uint32_t uid, Duration patience) {
  look_up(uid);
  const Entry& entry = entries_[uid];
  std::optional<StillTime> still;
  if (entry.under_way) still.emplace(clock_);
  const MonoTime deadline = entry.begun + patience;
  const auto is_over = [&entry] { return entry.name || !entry.under_way; };
  co_await changed_.wait(is_over, deadline);
  co_return known(uid);
}

}  // namespace lcrig
