// SPDX-License-Identifier: Apache-2.0
#include "render_chain.hpp"

#include <triad/base/error.hpp>
#include <triad/base/text.hpp>

#include "options.hpp"

namespace triad::app {

RenderChain::RenderChain(const std::string& text, std::vector<std::string> plugin_path)
    : text_(text), plugin_path_(std::move(plugin_path)) {
  if (text.ends_with(".toml")) {
    const Chain chain = load_chain(text);
    if (!chain.metrics.empty()) refuse_metric(chain.metrics[0].id);
    stages_ = chain.stages;
  } else {
    for (const std::string& stage : split_quoted(text, ' '))
      if (!stage.empty()) stages_.push_back(parse_stage(stage));
  }
  if (stages_.empty()) throw_usage("--chain '" + text + "' names no stage; write one as in platt:ppd=40");
  for (const ChainItem& stage : stages_)
    if (stage.is_write)
      throw_usage("--chain '" + text + "' writes '" + stage.path +
                  "', and a render writes one file, with -o; keep the render itself and give it to triad run");
}

void RenderChain::refuse_metric(const std::string& id) const {
  throw_usage("--chain '" + text_ + "' has the metric '" + id +
              "', and a render has no reference; judge what it writes with triad compare");
}

RunRequest RenderChain::request(Image image, const std::string& name, const std::string& output,
                                const WriteOptions& options) const {
  RunRequest request;
  request.input = {name, {}, std::make_shared<const Image>(std::move(image))};
  request.stages = stages_;
  request.output = output;
  request.write = options;
  return request;
}

ImageSpec RenderChain::check(const ImageSpec& spec, const std::string& output, const WriteOptions& options) const {
  PluginHost host(plugin_path_);
  const ColourConfig colours = ColourConfig::load();
  for (const ChainItem& stage : stages_)
    if (host.find(stage.id).is_metric()) refuse_metric(stage.id);
  // Planned; no pixel is read.
  const ImageSpec made = Run(request({spec, {}}, "the render", output, options), host, colours).output_spec();
  ImageWriter::open(output, made, options);
  return made;
}

double RenderChain::write(Image image, const std::string& name, const std::string& output,
                          const WriteOptions& options) const {
  PluginHost host(plugin_path_);
  const ColourConfig colours = ColourConfig::load();
  Progress progress(output);
  return Run(request(std::move(image), name, output, options), host, colours)
      .execute([&](double done) { progress.update(done); })
      .seconds;
}

}  // namespace triad::app
