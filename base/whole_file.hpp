// SPDX-License-Identifier: Apache-2.0
// Writes a file that is there whole or not at all, also when the power fails. The command line, the
// daemon's metrics and copies of a database are written with it.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace lcrig {

// A new file beside `path` (NAME.PID-N.part) that may take its name when it is whole; otherwise the
// destructor removes it. A file that a crash left behind is not in the way, and a link that
// somebody put there is not followed. Errors: io with the path.
class PartFile {
 public:
  static Result<PartFile> create(const std::string& path);
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;
  ~PartFile();
  int fd() const { return fd_; }
  const std::string& name() const { return name_; }
  // Everybody may read it, whatever the program's umask says. Errors: io with the path.
  Result<> open_to_all();
  // To the disk, then under its name: in place of what has it, or only while nothing has it.
  Result<> replace();
  Result<> put_new();

 private:
  PartFile(std::string path, std::string name, int fd);
  Result<> sync_and_close();
  Result<> take_free_name();
  std::string path_, name_;  // name_ empty: it is there under its name
  int fd_ = -1;
};

// `write` fills a new file, which then takes the name of `path`. Errors: what `write` said, or io
// with the path; nothing is left behind.
Result<> write_whole_file(const std::string& path, const std::function<Result<>(int fd)>& write);
Result<> write_whole_file(const std::string& path, std::string_view text);

// Whether the output of a program may replace what is at `path`: nothing, an empty file, or an
// earlier output of the same kind, which has `mark` within its first 4 KiB. Links are followed.
// Devices, pipes and folders are not judged. Errors: invalid_request, saying what would be lost.
Result<> require_earlier_output(const std::string& path, std::string_view mark);

// All of it, to a descriptor of the file `path`. Errors: io with the path.
Result<> write_text(int fd, const std::string& path, std::string_view text);

}  // namespace lcrig
