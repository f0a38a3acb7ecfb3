// SPDX-License-Identifier: Apache-2.0
#include "storage/forwarding_vfs.hpp"

#include <utility>

namespace lcrig {

// The callbacks that SQLite calls.
struct ForwardingMethods {
  using File = ForwardingVfs::File;

  static ForwardingVfs& vfs_of(sqlite3_vfs* vfs) {
    return *static_cast<ForwardingVfs*>(vfs->pAppData);
  }
  static File& file_of(sqlite3_file* f) { return *reinterpret_cast<File*>(f); }
  static sqlite3_file* real_of(sqlite3_file* f) { return file_of(f).real(); }

  static int open(sqlite3_vfs* vfs, sqlite3_filename path, sqlite3_file* f, int flags, int* out) {
    File& file = file_of(f);
    file.base.pMethods = nullptr;  // SQLite closes only files with methods
    file.vfs = &vfs_of(vfs);
    file.own = nullptr;
    const int rc = file.vfs->open(file, path, flags, out);
    if (rc == SQLITE_OK) file.base.pMethods = &methods();
    return rc;
  }
  static int remove(sqlite3_vfs* vfs, const char* path, int sync) {
    return vfs_of(vfs).remove(path, sync);
  }
  static int write(sqlite3_file* f, const void* data, int n, sqlite3_int64 at) {
    return file_of(f).vfs->write(file_of(f), data, n, at);
  }
  static int truncate(sqlite3_file* f, sqlite3_int64 bytes) {
    return file_of(f).vfs->truncate(file_of(f), bytes);
  }
  static int sync(sqlite3_file* f, int flags) { return file_of(f).vfs->sync(file_of(f), flags); }

  static const sqlite3_io_methods& methods() {
    static const sqlite3_io_methods m = make();
    return m;
  }

  static sqlite3_io_methods make() {
    sqlite3_io_methods m{};
    m.iVersion = 2;  // version 2 has no xFetch: no writes through mapped memory
    m.xClose = [](sqlite3_file* f) { return real_of(f)->pMethods->xClose(real_of(f)); };
    m.xRead = [](sqlite3_file* f, void* to, int n, sqlite3_int64 at) {
      return real_of(f)->pMethods->xRead(real_of(f), to, n, at);
    };
    m.xWrite = &write;
    m.xTruncate = &truncate;
    m.xSync = &sync;
    m.xFileSize = [](sqlite3_file* f, sqlite3_int64* n) {
      return real_of(f)->pMethods->xFileSize(real_of(f), n);
    };
    m.xLock = [](sqlite3_file* f, int l) { return real_of(f)->pMethods->xLock(real_of(f), l); };
    m.xUnlock = [](sqlite3_file* f, int l) { return real_of(f)->pMethods->xUnlock(real_of(f), l); };
    m.xCheckReservedLock = [](sqlite3_file* f, int* out) {
      return real_of(f)->pMethods->xCheckReservedLock(real_of(f), out);
    };
    m.xFileControl = [](sqlite3_file* f, int op, void* a) {
      return real_of(f)->pMethods->xFileControl(real_of(f), op, a);
    };
    m.xSectorSize = [](sqlite3_file* f) { return real_of(f)->pMethods->xSectorSize(real_of(f)); };
    m.xDeviceCharacteristics = [](sqlite3_file* f) {
      return real_of(f)->pMethods->xDeviceCharacteristics(real_of(f));
    };
    add_shared_memory(m);
    return m;
  }

  static void add_shared_memory(sqlite3_io_methods& m) {
    m.xShmMap = [](sqlite3_file* f, int page, int size, int extend, void volatile** to) {
      return real_of(f)->pMethods->xShmMap(real_of(f), page, size, extend, to);
    };
    m.xShmLock = [](sqlite3_file* f, int at, int n, int flags) {
      return real_of(f)->pMethods->xShmLock(real_of(f), at, n, flags);
    };
    m.xShmBarrier = [](sqlite3_file* f) { real_of(f)->pMethods->xShmBarrier(real_of(f)); };
    m.xShmUnmap = [](sqlite3_file* f, int del) {
      return real_of(f)->pMethods->xShmUnmap(real_of(f), del);
    };
  }
};

ForwardingVfs::ForwardingVfs(std::string name, bool takes_over)
    : name_(std::move(name)), real_(sqlite3_vfs_find(nullptr)), vfs_(*real_) {
  vfs_.zName = name_.c_str();
  vfs_.pNext = nullptr;
  vfs_.pAppData = this;
  vfs_.szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
  vfs_.xOpen = &ForwardingMethods::open;
  vfs_.xDelete = &ForwardingMethods::remove;
  sqlite3_vfs_register(&vfs_, takes_over ? 1 : 0);
}

ForwardingVfs::~ForwardingVfs() {
  sqlite3_vfs_unregister(&vfs_);
}

int ForwardingVfs::open(File& file, sqlite3_filename path, int flags, int* out_flags) {
  return real_->xOpen(real_, path, file.real(), flags, out_flags);
}
int ForwardingVfs::remove(const char* path, int sync) {
  return real_->xDelete(real_, path, sync);
}
int ForwardingVfs::write(File& file, const void* data, int bytes, sqlite3_int64 at) {
  return file.real()->pMethods->xWrite(file.real(), data, bytes, at);
}
int ForwardingVfs::truncate(File& file, sqlite3_int64 bytes) {
  return file.real()->pMethods->xTruncate(file.real(), bytes);
}
int ForwardingVfs::sync(File& file, int flags) {
  return file.real()->pMethods->xSync(file.real(), flags);
}

}  // namespace lcrig
