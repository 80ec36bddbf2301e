// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <triad/image/internal/output_proxy.hpp>

namespace triad::image {
namespace {
constexpr size_t kBuffer = 1 << 20;  // bytes
}

OutputProxy::OutputProxy(const std::string& path) : IOProxy(path, Write) {
  descriptor_ = open(path.c_str(), O_RDWR | O_TRUNC | O_CLOEXEC);
  if (descriptor_ < 0) error_ = errno;
}

OutputProxy::~OutputProxy() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputProxy::finish() {
  flush_buffer();
  if (descriptor_ >= 0 && ::close(descriptor_) != 0 && error_ == 0) error_ = errno;
  descriptor_ = -1;
}

void OutputProxy::flush_buffer() const {
  const char* data = buffer_.data();
  size_t left = buffer_.size();
  int64_t at = buffer_start_;
  while (left > 0 && error_ == 0) {
    const ssize_t n = ::pwrite(descriptor_, data, left, at);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      error_ = n < 0 ? errno : ENOSPC;
      break;
    }
    data += n;
    at += n;
    left -= static_cast<size_t>(n);
  }
  buffer_start_ += static_cast<int64_t>(buffer_.size());
  buffer_.clear();
}

bool OutputProxy::seek(int64_t offset) {
  if (offset < 0) return false;
  position_ = offset;
  return true;
}

size_t OutputProxy::write(const void* data, size_t size) {
  if (position_ != buffer_start_ + static_cast<int64_t>(buffer_.size()) || buffer_.size() + size > kBuffer) {
    flush_buffer();
    buffer_start_ = position_;
  }
  const char* bytes = static_cast<const char*>(data);
  buffer_.insert(buffer_.end(), bytes, bytes + size);
  position_ += static_cast<int64_t>(size);
  length_ = std::max(length_, position_);
  return size;
}

size_t OutputProxy::read(void* out, size_t size) {
  const size_t n = pread(out, size, position_);
  position_ += static_cast<int64_t>(n);
  return n;
}

size_t OutputProxy::pread(void* out, size_t size, int64_t offset) {
  flush_buffer();
  if (error_ != 0) return 0;
  const ssize_t n = ::pread(descriptor_, out, size, offset);
  return n < 0 ? 0 : static_cast<size_t>(n);
}

size_t OutputProxy::pwrite(const void* data, size_t size, int64_t offset) {
  const int64_t before = position_;
  position_ = offset;
  const size_t n = write(data, size);
  position_ = before;
  return n;
}

size_t OutputProxy::size() const { return static_cast<size_t>(length_); }

}  // namespace triad::image
