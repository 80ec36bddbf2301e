// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/numeric/value_store.hpp>

namespace triad {
namespace {

std::string folder() {
  const char* wanted = std::getenv("TMPDIR");
  return wanted && *wanted ? wanted : "/tmp";
}

[[noreturn]] void fail(const std::string& what, uint64_t bytes, int error) {
  throw_input("pooling a metric's map takes " + format_bytes(bytes) + " of temporary space, and '" + folder() + "' " +
              what + ": " + std::strerror(error) + "; TMPDIR names another folder");
}

int open_unnamed(uint64_t bytes) {
  std::string name = folder() + "/triad-XXXXXX";
  const int file = mkostemp(name.data(), O_CLOEXEC);
  if (file < 0) fail("takes no file", bytes, errno);
  unlink(name.c_str());
  return file;
}

void write_all(int file, const void* data, uint64_t count, uint64_t at, uint64_t wanted) {
  const char* from = static_cast<const char*>(data);
  while (count > 0) {
    const ssize_t done = pwrite(file, from, count, static_cast<off_t>(at));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) fail("cannot hold them", wanted, done < 0 ? errno : ENOSPC);
    from += done;
    at += static_cast<uint64_t>(done);
    count -= static_cast<uint64_t>(done);
  }
}

void read_all(int file, void* data, uint64_t count, uint64_t at) {
  char* to = static_cast<char*>(data);
  while (count > 0) {
    const ssize_t done = pread(file, to, count, static_cast<off_t>(at));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) fail("does not give them back", count, done < 0 ? errno : EIO);
    to += done;
    at += static_cast<uint64_t>(done);
    count -= static_cast<uint64_t>(done);
  }
}

}  // namespace

ValueStore::ValueStore(bool weighted, uint64_t keep_bytes, uint64_t values_expected)
    : weighted_(weighted), keep_bytes_(keep_bytes), expected_(values_expected) {}

ValueStore::~ValueStore() {
  for (const int file : file_)
    if (file >= 0) close(file);
}

ValueStore::Chunk ValueStore::make_chunk(size_t capacity, bool weighted) {
  Chunk chunk;
  chunk.values = std::make_unique_for_overwrite<uint32_t[]>(capacity);
  if (weighted) chunk.weights = std::make_unique_for_overwrite<uint16_t[]>(capacity);
  chunk.capacity = capacity;
  return chunk;
}

void ValueStore::write(const Chunk& chunk, uint64_t at) const {
  const uint64_t wanted = expected_ * (weighted_ ? 6 : 4);
  write_all(file_[0], chunk.values.get(), chunk.count * sizeof(uint32_t), at * sizeof(uint32_t), wanted);
  if (weighted_)
    write_all(file_[1], chunk.weights.get(), chunk.count * sizeof(uint16_t), at * sizeof(uint16_t), wanted);
}

void ValueStore::spill() {
  const uint64_t wanted = expected_ * (weighted_ ? 6 : 4);
  file_[0] = open_unnamed(wanted);
  if (weighted_) file_[1] = open_unnamed(wanted);
  uint64_t at = 0;
  for (const Chunk& chunk : chunks_) {
    write(chunk, at);
    at += chunk.count;
  }
  std::vector<Chunk>().swap(chunks_);
}

void ValueStore::add(Chunk& chunk) {
  if (chunk.count == 0) return;
  uint64_t at = 0;
  {
    const std::lock_guard lock(mutex_);
    if (!spilled() && held_bytes_ + chunk.count * (weighted_ ? 6 : 4) > keep_bytes_) spill();
    if (!spilled()) {
      if (chunk.count < chunk.capacity / 2) {  // a mask left most of them out
        Chunk small = make_chunk(chunk.count, weighted_);
        std::copy_n(chunk.values.get(), chunk.count, small.values.get());
        if (weighted_) std::copy_n(chunk.weights.get(), chunk.count, small.weights.get());
        small.count = chunk.count;
        chunk = std::move(small);
      }
      held_bytes_ += chunk.capacity * (weighted_ ? 6 : 4);
      count_ += chunk.count;
      chunks_.push_back(std::move(chunk));
      chunk = {};
      return;
    }
    at = count_;
    count_ += chunk.count;
  }
  write(chunk, at);
  chunk.count = 0;
}

void ValueStore::visit(int part, int parts,
                       const std::function<void(const uint32_t*, const uint16_t*, size_t)>& use) const {
  constexpr uint64_t kBlock = 1 << 18;  // values read at a time
  if (!spilled()) {
    for (size_t i = static_cast<size_t>(part); i < chunks_.size(); i += static_cast<size_t>(parts))
      use(chunks_[i].values.get(), chunks_[i].weights.get(), chunks_[i].count);
    return;
  }
  const uint64_t blocks = (count_ + kBlock - 1) / kBlock;
  const Chunk buffer = make_chunk(kBlock, weighted_);
  for (uint64_t block = static_cast<uint64_t>(part); block < blocks; block += static_cast<uint64_t>(parts)) {
    const uint64_t at = block * kBlock, count = std::min(kBlock, count_ - at);
    read_all(file_[0], buffer.values.get(), count * sizeof(uint32_t), at * sizeof(uint32_t));
    if (weighted_) read_all(file_[1], buffer.weights.get(), count * sizeof(uint16_t), at * sizeof(uint16_t));
    use(buffer.values.get(), buffer.weights.get(), count);
  }
}

}  // namespace triad
