// SPDX-License-Identifier: Apache-2.0
// An SQLite VFS that forwards everything to the real one. Base class of simulated disks:
// FaultyDisk, and the power cuts of the tests.
#pragma once

#include <sqlite3.h>

#include <string>

namespace lcrig {

// Registered with SQLite while it exists. Must outlive every connection opened with its name.
class ForwardingVfs {
 public:
  // With `takes_over` it becomes the default VFS of the process.
  explicit ForwardingVfs(std::string name, bool takes_over = false);
  virtual ~ForwardingVfs();
  ForwardingVfs(const ForwardingVfs&) = delete;
  ForwardingVfs& operator=(const ForwardingVfs&) = delete;
  const std::string& name() const { return name_; }

 protected:
  // An open file. SQLite allocates its memory, with the real file behind it, so it has no
  // constructor.
  struct File {
    sqlite3_file base;
    ForwardingVfs* vfs;
    void* own;  // data of the derived class, set in its `open`
    sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
  };

  // All return an SQLite result code. `path` is nullptr for a temporary file.
  virtual int open(File& file, sqlite3_filename path, int flags, int* out_flags);
  virtual int remove(const char* path, int sync);
  virtual int write(File& file, const void* data, int bytes, sqlite3_int64 at);
  virtual int truncate(File& file, sqlite3_int64 bytes);
  virtual int sync(File& file, int flags);

  sqlite3_vfs& real() { return *real_; }

 private:
  friend struct ForwardingMethods;

  std::string name_;
  sqlite3_vfs* real_;
  sqlite3_vfs vfs_;
};

}  // namespace lcrig
