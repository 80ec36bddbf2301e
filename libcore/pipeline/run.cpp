// SPDX-License-Identifier: Apache-2.0
#include <triad/base/error.hpp>
#include <triad/pipeline/run_impl.hpp>

namespace triad {

const std::vector<std::string>& pooled_score_names() {
  static const std::vector<std::string> kNames{
      "mean", "min",         "p5",           "p25",          "p50",          "p75",          "p95",         "p99",
      "max",  "weighted-p5", "weighted-p25", "weighted-p50", "weighted-p75", "weighted-p95", "weighted-p99"};
  return kNames;
}

Run::Run(RunRequest request, PluginHost& host, const ColourConfig& colours)
    : impl_(std::make_unique<Impl>(std::move(request), host, colours)) {}
Run::~Run() = default;
std::string Run::explain() const { return impl_->explain(); }
uint64_t Run::peak_memory() const { return impl_->peak_bytes; }
const ImageSpec& Run::output_spec() const {
  for (const PictureOutput& out : impl_->outputs)
    if (!out.path.empty() && out.path == impl_->request.output) return out.spec;
  throw_internal("a run without an output was asked for its header");
}
RunResult Run::execute(const std::function<void(double)>& progress) { return impl_->execute(progress); }

}  // namespace triad
