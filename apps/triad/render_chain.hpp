// SPDX-License-Identifier: Apache-2.0
// Filters that a render goes through before it is written: triad render --chain.
#pragma once

#include <string>
#include <triad/pipeline/chain.hpp>
#include <triad/pipeline/run.hpp>
#include <vector>

namespace triad::app {

class RenderChain {
 public:
  RenderChain() = default;  // none
  // Stages with blanks between them as triad run takes them, or a chain's TOML file. Throws Error(kUsage) naming
  // --chain for what is no chain of filters, or writes files.
  RenderChain(const std::string& text, std::vector<std::string> plugin_path);

  bool empty() const { return stages_.empty(); }
  const std::string& text() const { return text_; }
  // Throws now what write() of a picture with this header would throw of stages, sizes, colours and the output, and
  // leaves nothing behind. Returns the header of what write() would write.
  ImageSpec check(const ImageSpec& spec, const std::string& output, const WriteOptions& options) const;
  // The picture as triad run would write it. Returns the seconds that filters and file took. `name` is for messages.
  double write(Image image, const std::string& name, const std::string& output, const WriteOptions& options) const;

 private:
  [[noreturn]] void refuse_metric(const std::string& id) const;
  RunRequest request(Image image, const std::string& name, const std::string& output,
                     const WriteOptions& options) const;

  std::string text_;
  std::vector<std::string> plugin_path_;
  std::vector<ChainItem> stages_;
};

}  // namespace triad::app
