// SPDX-License-Identifier: Apache-2.0
// Finds users' names for messages. Only the uid is certain, because it comes from the kernel. Names
// are looked up on separate threads, because a directory service that does not answer blocks its
// caller for minutes. Used by ControlServer.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "base/condition.hpp"

namespace lcrig {

// To be used on the io_context's thread. `clock` must outlive it.
class UserNames {
 public:
  // Called on any thread; may be slow. nullopt: the user has no known name.
  using Lookup = std::function<std::optional<std::string>(std::uint32_t uid)>;
  static std::optional<std::string> of_system(std::uint32_t uid);

  UserNames(asio::any_io_executor executor, Clock& clock, Lookup lookup);
  ~UserNames();  // does not wait for lookups
  UserNames(const UserNames&) = delete;
  UserNames& operator=(const UserNames&) = delete;

  // Starts a lookup, unless one is in progress or was done less than a minute ago.
  void look_up(std::uint32_t uid);
  std::string known(std::uint32_t uid) const;  // returns at once: the name, or "uid 1000"
  // The same, but waits for the name until `patience` after its lookup began. A second caller
  // therefore does not wait again while a service hangs.
  Task<std::string> find(std::uint32_t uid, Duration patience);

 private:
  struct Entry {
    std::optional<std::string> name;
    MonoTime begun;
    bool under_way = false;
  };
  struct Link;
  void learn(std::uint32_t uid, std::optional<std::string> name);

  asio::any_io_executor executor_;
  Clock& clock_;
  Lookup lookup_;
  std::map<std::uint32_t, Entry> entries_;
  std::size_t under_way_ = 0;
  Condition changed_;
  std::shared_ptr<Link> link_;  // leads threads to this object, which they may outlive
};

// Words for a user without a known name: "uid 1000".
std::string uid_words(std::uint32_t uid);

}  // namespace lcrig
