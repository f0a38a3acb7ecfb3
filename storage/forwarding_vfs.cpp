// SPDX-License-Identifier: Apache-2.0
#include "storage/forwarding_vfs.hpp"

#include <utility>

namespace lcrig {

// The callbacks that SQLite calls, which forward to ForwardingVfs.
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

  using Methods = sqlite3_io_methods;

  // Methods that no derived class overrides call the real file directly.
  template <auto method, class R, class... Args>
  static void pass_on(Methods& m, R (*Methods::*)(sqlite3_file*, Args...)) {
    m.*method = [](sqlite3_file* f, Args... args) -> R {
      return (real_of(f)->pMethods->*method)(real_of(f), args...);
    };
  }
  template <auto... methods>
  static void pass_on(Methods& m) {
    (pass_on<methods>(m, methods), ...);
  }

  static Methods make() {
    Methods m{};
    m.iVersion = 2;  // version 2 has no xFetch: no writes through mapped memory
    m.xWrite = &write;
    m.xTruncate = &truncate;
    m.xSync = &sync;
    pass_on<&Methods::xClose, &Methods::xRead, &Methods::xFileSize, &Methods::xLock,
            &Methods::xUnlock, &Methods::xCheckReservedLock, &Methods::xFileControl,
            &Methods::xSectorSize, &Methods::xDeviceCharacteristics>(m);
    pass_on<&Methods::xShmMap, &Methods::xShmLock, &Methods::xShmBarrier, &Methods::xShmUnmap>(m);
    return m;
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
