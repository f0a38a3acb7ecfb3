// SPDX-License-Identifier: Apache-2.0
// A power cut for SQLite. This VFS distinguishes what was synced from what was only written. At the
// nth write the power "fails". The disk then holds the synced image and any part of the unsynced
// writes, with torn sectors. The program goes on writing the real files, but nobody reads them any
// more.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "storage/forwarding_vfs.hpp"

namespace lcrig::support {

class PowerCutVfs final : public ForwardingVfs {
 public:
  explicit PowerCutVfs(std::uint64_t seed)
      : ForwardingVfs("lcrig-power-cut", true), random_(seed) {}

  void cut_after(int writes) { left_ = writes; }
  bool is_cut() const { return cut_; }
  // Writes to `folder` the files that a reader finds once the power is back.
  void write_survivors(const std::string& folder) const {
    for (const auto& [path, bytes] : survivors_) {
      const auto name = path.substr(path.rfind('/') + 1);
      std::ofstream out(folder + "/" + name, std::ios::binary);
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
  }

 private:
  struct Change {  // a write, or a truncation
    std::size_t offset = 0;
    std::vector<char> bytes;
    bool truncates = false;
  };
  struct Image {
    std::vector<char> synced;
    std::vector<Change> pending;
  };
  // nullptr for a temporary file.
  static Image* image_of(const File& file) { return static_cast<Image*>(file.own); }

  static void apply(std::vector<char>& to, const Change& c) {
    if (c.truncates) return to.resize(c.offset);
    if (to.size() < c.offset + c.bytes.size()) to.resize(c.offset + c.bytes.size());
    std::copy(c.bytes.begin(), c.bytes.end(), to.begin() + static_cast<std::ptrdiff_t>(c.offset));
  }

  // Some sectors of a write reach the disk, others do not.
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

  int open(File& file, sqlite3_filename path, int flags, int* out_flags) override {
    if (path != nullptr) file.own = &images_[path];
    return ForwardingVfs::open(file, path, flags, out_flags);
  }
  int remove(const char* path, int sync) override {
    images_[path] = Image();
    return ForwardingVfs::remove(path, sync);
  }
  int write(File& file, const void* data, int bytes, sqlite3_int64 at) override {
    Change change;
    change.offset = static_cast<std::size_t>(at);
    const char* begin = static_cast<const char*>(data);
    change.bytes.assign(begin, begin + bytes);
    changed(image_of(file), std::move(change));
    return ForwardingVfs::write(file, data, bytes, at);
  }
  int truncate(File& file, sqlite3_int64 bytes) override {
    Change change;
    change.offset = static_cast<std::size_t>(bytes);
    change.truncates = true;
    changed(image_of(file), std::move(change));
    return ForwardingVfs::truncate(file, bytes);
  }
  int sync(File& file, int flags) override {
    if (Image* image = image_of(file)) {
      for (const Change& c : image->pending) apply(image->synced, c);
      image->pending.clear();
    }
    return ForwardingVfs::sync(file, flags);
  }

  std::mt19937_64 random_;
  std::map<std::string, Image> images_;  // by path; a map, because addresses must not change
  std::map<std::string, std::vector<char>> survivors_;
  int left_ = -1;  // writes until the cut; negative: never
  bool cut_ = false;
};

}  // namespace lcrig::support
