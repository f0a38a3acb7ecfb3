// SPDX-License-Identifier: Apache-2.0
// Writes a file completely or not at all, even when the power fails. Used for the command line's
// outputs, the daemon's metrics and copies of a database.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace lcrig {

// A new file beside `path` (NAME.PID-N.part) that takes the name of `path` when it is complete;
// otherwise the destructor removes it. A file that a crash left behind does not disturb it, and a
// link under its name is not followed. Errors: io with the path.
class PartFile {
 public:
  static Result<PartFile> create(const std::string& path);
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;
  ~PartFile();
  int fd() const { return fd_; }
  const std::string& name() const { return name_; }
  // Makes it readable for everybody, whatever the umask. Errors: io with the path.
  Result<> open_to_all();
  // Syncs the file and gives it its name: `replace` also over an existing file, `put_new` only if
  // the name is free.
  Result<> replace();
  Result<> put_new();

 private:
  PartFile(std::string path, std::string name, int fd);
  Result<> sync_and_close();
  Result<> take_free_name();
  std::string path_, name_;  // name_ is empty once the file has its final name
  int fd_ = -1;
};

// Lets `write` fill a new file, which then takes the name of `path`. Errors: that of `write`, or io
// with the path; nothing is left behind.
Result<> write_whole_file(const std::string& path, const std::function<Result<>(int fd)>& write);
Result<> write_whole_file(const std::string& path, std::string_view text);

// Whether the output of a program may replace what is at `path`: nothing, an empty file, or an
// earlier output of the same kind, recognised by `mark` within its first 4 KiB. Links are followed.
// Devices, pipes and folders are not checked. Errors: invalid_request, saying what would be lost.
Result<> require_earlier_output(const std::string& path, std::string_view mark);

// Writes all of `text` to a descriptor of the file `path`. Errors: io with the path.
Result<> write_text(int fd, const std::string& path, std::string_view text);

}  // namespace lcrig
