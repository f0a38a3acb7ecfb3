// SPDX-License-Identifier: Apache-2.0
// A power cut for SQLite: a VFS that remembers what was synced and what was only written. At the
// nth write the power "fails": what is then on the disk is the synced image and any part of the
// unsynced writes, sectors torn. The real files go on, nobody looks at them any more.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace lcrig::support {

class PowerCutVfs {
 public:
  explicit PowerCutVfs(std::uint64_t seed) : random_(seed), real_(sqlite3_vfs_find(nullptr)) {
    vfs_ = *real_;
    vfs_.zName = "lcrig-power-cut";
    vfs_.pNext = nullptr;
    vfs_.pAppData = this;
    vfs_.szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
    vfs_.xOpen = &open;
    vfs_.xDelete = &remove;
    sqlite3_vfs_register(&vfs_, 1);
  }
  ~PowerCutVfs() { sqlite3_vfs_unregister(&vfs_); }
  PowerCutVfs(const PowerCutVfs&) = delete;
  PowerCutVfs& operator=(const PowerCutVfs&) = delete;

  void cut_after(int writes) { left_ = writes; }
  bool is_cut() const { return cut_; }
  // What a reader finds after the power came back, as files in `folder`.
  void write_survivors(const std::string& folder) const {
    for (const auto& [path, bytes] : survivors_) {
      const auto name = path.substr(path.rfind('/') + 1);
      std::ofstream out(folder + "/" + name, std::ios::binary);
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
  }

 private:
  struct Change {  // a write; or, without bytes, a truncation
    std::size_t offset = 0;
    std::vector<char> bytes;
    bool truncates = false;
  };
  struct Image {
    std::vector<char> synced;
    std::vector<Change> pending;
  };
  struct File {  // the real file follows it in memory
    sqlite3_file base;
    PowerCutVfs* world;
    Image* image;  // nullptr: a temporary file
    sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
  };
  static File* file_of(sqlite3_file* f) { return reinterpret_cast<File*>(f); }
  static sqlite3_file* real_of(sqlite3_file* f) { return file_of(f)->real(); }

  static void apply(std::vector<char>& to, const Change& c) {
    if (c.truncates) return to.resize(c.offset);
    if (to.size() < c.offset + c.bytes.size()) to.resize(c.offset + c.bytes.size());
    std::copy(c.bytes.begin(), c.bytes.end(), to.begin() + static_cast<std::ptrdiff_t>(c.offset));
  }

  // Sectors of one write reach the disk in any order, or not.
  void apply_torn(std::vector<char>& to, const Change& c) {
    constexpr std::size_t kSector = 512;
    if (c.truncates || random_() % 3 == 0) return apply(to, c);
    for (std::size_t at = 0; at < c.bytes.size(); at += kSector) {
      if (random_() % 2 == 0) continue;
      Change part;
      part.offset = c.offset + at;
      const auto begin = c.bytes.begin() + static_cast<std::ptrdiff_t>(at);
      const auto length = std::min(kSector, c.bytes.size() - at);
      part.bytes.assign(begin, begin + static_cast<std::ptrdiff_t>(length));
      apply(to, part);
    }
  }

  void changed(Image* image, Change change) {
    if (image == nullptr || cut_) return;
    image->pending.push_back(std::move(change));
    if (left_ < 0 || --left_ > 0) return;
    cut_ = true;
    for (const auto& [path, each] : images_) {
      std::vector<char> bytes = each.synced;
      for (const Change& c : each.pending) {
        if (random_() % 2 == 0) apply_torn(bytes, c);
      }
      survivors_[path] = std::move(bytes);
    }
  }

  static int open(sqlite3_vfs* vfs, sqlite3_filename name, sqlite3_file* f, int flags, int* out) {
    auto* world = static_cast<PowerCutVfs*>(vfs->pAppData);
    File* file = file_of(f);
    file->base.pMethods = nullptr;
    file->world = world;
    file->image = name != nullptr ? &world->images_[name] : nullptr;
    const int rc = world->real_->xOpen(world->real_, name, file->real(), flags, out);
    if (rc == SQLITE_OK) file->base.pMethods = &methods();
    return rc;
  }
  static int remove(sqlite3_vfs* vfs, const char* name, int sync) {
    auto* world = static_cast<PowerCutVfs*>(vfs->pAppData);
    world->images_[name] = Image();
    return world->real_->xDelete(world->real_, name, sync);
  }

  static int write(sqlite3_file* f, const void* data, int n, sqlite3_int64 at) {
    Change change;
    change.offset = static_cast<std::size_t>(at);
    const char* bytes = static_cast<const char*>(data);
    change.bytes.assign(bytes, bytes + n);
    file_of(f)->world->changed(file_of(f)->image, std::move(change));
    return real_of(f)->pMethods->xWrite(real_of(f), data, n, at);
  }
  static int truncate(sqlite3_file* f, sqlite3_int64 size) {
    Change change;
    change.offset = static_cast<std::size_t>(size);
    change.truncates = true;
    file_of(f)->world->changed(file_of(f)->image, std::move(change));
    return real_of(f)->pMethods->xTruncate(real_of(f), size);
  }
  static int sync(sqlite3_file* f, int flags) {
    Image* image = file_of(f)->image;
    if (image != nullptr) {
      for (const Change& c : image->pending) apply(image->synced, c);
      image->pending.clear();
    }
    return real_of(f)->pMethods->xSync(real_of(f), flags);
  }

  static const sqlite3_io_methods& methods() {
    static const sqlite3_io_methods m = make_methods();
    return m;
  }
  static sqlite3_io_methods make_methods() {
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

  std::mt19937_64 random_;
  sqlite3_vfs* real_;
  sqlite3_vfs vfs_{};
  std::map<std::string, Image> images_;  // by path; addresses stay
  std::map<std::string, std::vector<char>> survivors_;
  int left_ = -1;  // writes until the cut; below 0: never
  bool cut_ = false;
};

}  // namespace lcrig::support
