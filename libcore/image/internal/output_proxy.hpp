// SPDX-License-Identifier: Apache-2.0
// The file beneath an encoder. Not installed.
#pragma once

#include <OpenImageIO/filesystem.h>

#include <string>
#include <vector>

namespace triad::image {

// Writes on behalf of OpenImageIO's encoders, some of which drop the errors of the system (a full disk seen
// only when the last buffer is flushed, for one). Remembers the first error; after one, further writes claim to
// succeed, so that no encoder retries or prints.
class OutputProxy final : public OIIO::Filesystem::IOProxy {
 public:
  // Opens and empties an existing file.
  explicit OutputProxy(const std::string& path);
  ~OutputProxy() override;

  const char* proxytype() const override { return "triad"; }
  void close() override {}  // encoders close early; finish() is ours
  int64_t tell() override { return position_; }
  bool seek(int64_t offset) override;
  size_t read(void* out, size_t size) override;
  size_t write(const void* data, size_t size) override;
  size_t pread(void* out, size_t size, int64_t offset) override;
  size_t pwrite(const void* data, size_t size, int64_t offset) override;
  size_t size() const override;
  void flush() const override {}

  // The first failure's errno, or 0.
  int error_number() const { return error_; }
  // Writes what is buffered, and closes. Then error_number() is final.
  void finish();

 private:
  void flush_buffer() const;

  int descriptor_ = -1;
  int64_t position_ = 0;
  // Bytes that begin at buffer_start_ of the file; encoders write a few bytes at a time.
  mutable std::vector<char> buffer_;
  mutable int64_t buffer_start_ = 0;
  mutable int64_t length_ = 0;  // of the file, buffer included
  mutable int error_ = 0;
};

}  // namespace triad::image
