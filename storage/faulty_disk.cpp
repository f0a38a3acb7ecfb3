// SPDX-License-Identifier: Apache-2.0
#include "storage/faulty_disk.hpp"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <fmt/format.h>

#include <mutex>

namespace lcrig {

namespace {

constexpr std::int64_t kNever = -1;

}  // namespace

// The state is read by the writer's thread and set by another one.
struct FaultyDisk::Vfs {
  sqlite3_vfs vfs{};
  sqlite3_vfs* real = nullptr;
  std::string name;

  std::atomic<bool> full = false, read_only = false;
  std::atomic<std::int64_t> delay_us = 0;
  std::atomic<std::int64_t> operations = 0;
  std::atomic<std::int64_t> fail_at = kNever;  // of `operations`
  std::atomic<bool> failed = false;
  Failure how = Failure::io_error;

  std::mutex mutex;  // of the members below
  std::string reserve;  // path; empty until the main database was opened
  std::int64_t reserve_bytes = 0;  // when the disk became full
  std::int64_t grown_bytes = 0;  // since then

  static std::int64_t size_of(const std::string& path) {
    struct stat found{};
    return ::stat(path.c_str(), &found) == 0 ? found.st_size : 0;
  }

  void become_full(bool on) {
    const std::lock_guard lock(mutex);
    reserve_bytes = size_of(reserve);
    grown_bytes = 0;
    full = on;
  }

  bool has_room(std::int64_t bytes) {
    const std::lock_guard lock(mutex);
    const std::int64_t freed = reserve_bytes - size_of(reserve);
    if (grown_bytes + bytes > freed) return false;
    grown_bytes += bytes;
    return true;
  }

  // SQLITE_OK, or what goes wrong with this write, truncation or sync.
  int next_operation(int io_error) {
    const std::int64_t n = operations++;
    if (n == fail_at) {
      failed = true;
      return how == Failure::full ? SQLITE_FULL : io_error;
    }
    return read_only ? io_error : SQLITE_OK;
  }
};

namespace {

// The real file follows it in memory.
struct File {
  sqlite3_file base;
  void* disk;  // FaultyDisk::Vfs, which is private there
};
File* file_of(sqlite3_file* f) {
  return reinterpret_cast<File*>(f);
}
sqlite3_file* real_of(sqlite3_file* f) {
  return reinterpret_cast<sqlite3_file*>(file_of(f) + 1);
}

template <class Disk>
struct Methods {
  static Disk& disk_of(sqlite3_file* f) { return *static_cast<Disk*>(file_of(f)->disk); }

  static int open(sqlite3_vfs* vfs, sqlite3_filename name, sqlite3_file* f, int flags, int* out) {
    auto* disk = static_cast<Disk*>(vfs->pAppData);
    file_of(f)->base.pMethods = nullptr;
    file_of(f)->disk = disk;
    if (name != nullptr && (flags & SQLITE_OPEN_MAIN_DB) != 0) {
      const std::lock_guard lock(disk->mutex);
      disk->reserve = std::string(name) + ".reserve";
    }
    const bool writes = (flags & SQLITE_OPEN_READWRITE) != 0;
    if (disk->read_only && writes) {
      flags &= ~(SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_EXCLUSIVE);
      flags |= SQLITE_OPEN_READONLY;
    }
    const int rc = disk->real->xOpen(disk->real, name, real_of(f), flags, out);
    if (rc == SQLITE_OK) file_of(f)->base.pMethods = &methods();
    return rc;
  }

  static int remove(sqlite3_vfs* vfs, const char* name, int sync) {
    auto* disk = static_cast<Disk*>(vfs->pAppData);
    if (disk->read_only) return SQLITE_IOERR_DELETE;
    return disk->real->xDelete(disk->real, name, sync);
  }

  static int write(sqlite3_file* f, const void* data, int n, sqlite3_int64 at) {
    Disk& disk = disk_of(f);
    if (const int rc = disk.next_operation(SQLITE_IOERR_WRITE); rc != SQLITE_OK) return rc;
    if (disk.full) {
      sqlite3_int64 size = 0;
      const int rc = real_of(f)->pMethods->xFileSize(real_of(f), &size);
      if (rc != SQLITE_OK) return rc;
      if (at + n > size && !disk.has_room(at + n - size)) return SQLITE_FULL;
    }
    return real_of(f)->pMethods->xWrite(real_of(f), data, n, at);
  }

  static int truncate(sqlite3_file* f, sqlite3_int64 size) {
    const int rc = disk_of(f).next_operation(SQLITE_IOERR_TRUNCATE);
    return rc != SQLITE_OK ? rc : real_of(f)->pMethods->xTruncate(real_of(f), size);
  }

  static int sync(sqlite3_file* f, int flags) {
    Disk& disk = disk_of(f);
    if (const int rc = disk.next_operation(SQLITE_IOERR_FSYNC); rc != SQLITE_OK) return rc;
    const std::int64_t us = disk.delay_us;
    if (us > 0) disk.real->xSleep(disk.real, static_cast<int>(us));
    return real_of(f)->pMethods->xSync(real_of(f), flags);
  }

  static const sqlite3_io_methods& methods() {
    static const sqlite3_io_methods m = make();
    return m;
  }

  static sqlite3_io_methods make() {
    sqlite3_io_methods m{};
    m.iVersion = 2;  // without xFetch: no writes through mapped memory
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
    return m;
  }
};

}  // namespace

FaultyDisk::FaultyDisk() : vfs_(std::make_unique<Vfs>()) {
  Vfs& v = *vfs_;
  v.real = sqlite3_vfs_find(nullptr);
  v.name = fmt::format("lcrig-faulty-{}", static_cast<const void*>(this));
  v.vfs = *v.real;
  v.vfs.zName = v.name.c_str();
  v.vfs.pNext = nullptr;
  v.vfs.pAppData = &v;
  v.vfs.szOsFile = static_cast<int>(sizeof(File)) + v.real->szOsFile;
  v.vfs.xOpen = &Methods<Vfs>::open;
  v.vfs.xDelete = &Methods<Vfs>::remove;
  sqlite3_vfs_register(&v.vfs, 0);
}

FaultyDisk::~FaultyDisk() {
  sqlite3_vfs_unregister(&vfs_->vfs);
}

const std::string& FaultyDisk::name() const {
  return vfs_->name;
}

void FaultyDisk::set_full(bool on) {
  vfs_->become_full(on);
}
void FaultyDisk::set_read_only(bool on) {
  vfs_->read_only = on;
}
void FaultyDisk::set_sync_delay(Duration delay) {
  vfs_->delay_us = std::chrono::duration_cast<std::chrono::microseconds>(delay).count();
}

void FaultyDisk::fail_operation(std::int64_t n, Failure how) {
  vfs_->how = how;
  vfs_->failed = false;
  vfs_->fail_at = vfs_->operations + n;
}
bool FaultyDisk::has_failed() const {
  return vfs_->failed;
}
std::int64_t FaultyDisk::operations() const {
  return vfs_->operations;
}

void set_sqlite_memory_short(bool on) {
  // A hard limit that is below what is in use refuses every further allocation; 0 is no limit.
  sqlite3_hard_heap_limit64(on ? 1 : 0);
  if (!on) sqlite3_soft_heap_limit64(0);
}

}  // namespace lcrig
