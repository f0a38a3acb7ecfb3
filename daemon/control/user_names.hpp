// SPDX-License-Identifier: Apache-2.0
// The names of users, for people: the uid is what the kernel vouches for. Looked up on threads of
// their own, because a directory service that does not answer holds its caller for minutes.
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

// Used from the io_context's thread; `clock` outlives it.
class UserNames {
 public:
  // Called on any thread, and may take its time. None: nobody knows a name.
  using Lookup = std::function<std::optional<std::string>(std::uint32_t uid)>;
  static std::optional<std::string> of_system(std::uint32_t uid);

  UserNames(asio::any_io_executor executor, Clock& clock, Lookup lookup);
  ~UserNames();  // waits for no lookup
  UserNames(const UserNames&) = delete;
  UserNames& operator=(const UserNames&) = delete;

  // Begins to look a name up, unless that goes on or was done a minute ago.
  void look_up(std::uint32_t uid);
  std::string known(std::uint32_t uid) const;  // now: the name, or "uid 1000"
  // The same, but waits for the name, at most until `patience` after its lookup began: a second
  // caller does not wait again while a service hangs.
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
  std::shared_ptr<Link> link_;  // to this, for threads that outlive it
};

// Words for a user whose name is not known: "uid 1000".
std::string uid_words(std::uint32_t uid);

}  // namespace lcrig
