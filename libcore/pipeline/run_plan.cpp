// SPDX-License-Identifier: Apache-2.0
// What a Run reads, makes, writes and judges.
#include <algorithm>
#include <filesystem>
#include <map>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/run_impl.hpp>

namespace triad {
namespace {

bool keeps_all_channels(const std::string& path) {
  const std::string name = lower(path);
  return name.ends_with(".exr") || name.ends_with(".tif") || name.ends_with(".tiff");
}

std::unique_ptr<PictureSource> open_source(const PictureRequest& picture, const ColourConfig& colours) {
  return picture.image ? memory_source(*picture.image) : open_file_source(picture.path, picture.read, colours);
}

}  // namespace

Run::Impl::Impl(RunRequest made, PluginHost& host, const ColourConfig& config)
    : request(std::move(made)), colours(config) {
  open_input();
  add_filters(host);
  add_outputs();
  add_metrics(host);
  check_paths();
  plan_drives();
  fit_memory();
}

void Run::Impl::open_input() { input = open_source(request.input, colours); }

void Run::Impl::add_filters(PluginHost& host) {
  std::vector<StageInstance> instances;
  bool everything = request.metrics.empty() && !request.output.empty() && keeps_all_channels(request.output);
  for (const ChainItem& item : request.stages) {
    if (item.is_write) {
      everything = everything && keeps_all_channels(item.path);
      continue;
    }
    const StageInfo& info = host.find(item.id);
    if (info.is_metric()) throw_usage("'" + item.id + "' is a metric; write -m " + item.id + " --ref REFERENCE");
    instances.emplace_back(info, item.params);
    const char* channels = info.desc->inputs[0]->channels;
    everything = everything && (!channels || std::string(channels) == "*");
  }
  // Channels beside colour and alpha are decoded only where all stages take them along and the file that is
  // written can hold them.
  if (everything && !request.input.image && request.input.read.channels.empty() && request.input.read.layer.empty()) {
    ReadOptions all = request.input.read;
    all.all_channels = true;
    input = open_file_source(request.input.path, all, colours);
  }
  for (StageInstance& instance : instances) {
    filter_texts.push_back(instance.text());
    filters.push_back(std::make_unique<FilterNode>(std::move(instance), level(levels()), colours));
  }
}

void Run::Impl::add_outputs() {
  const auto add = [&](int at, const std::string& path) {
    const ImageSpec& from = level(at);
    PictureOutput out{at, path, {}, from};
    const bool encoded = is_display_encoded_format(path, request.write.depth);
    if (!from.colour_space.empty() && from.colour_channels > 0 && !colours.is_data(from.colour_space)) {
      const std::string to = !request.output_space.empty() ? colours.require(request.output_space, "--to")
                             : encoded                     ? colours.srgb()
                                                           : colours.linear_sibling(from.colour_space);
      out.transform = colours.transform(from.colour_space, to);
      out.spec.colour_space = to;
      // Files say the primaries of linear light; where they are the input's own, its own numbers.
      if (to != input->spec().colour_space || !out.spec.chromaticities)
        out.spec.chromaticities =
            encoded || colours.linear_sibling(to) != to ? std::nullopt : std::optional(colours.chromaticities(to));
    } else if (!request.output_space.empty()) {
      throw_usage("--to '" + request.output_space + "': '" + request.input.path +
                  "' holds no colour in a known space; say which with --from");
    }
    outputs.push_back(std::move(out));
  };
  int at = 0;
  for (const ChainItem& item : request.stages) {
    if (item.is_write)
      add(at, item.path);
    else
      ++at;
  }
  if (!request.output.empty()) add(levels(), request.output);
  if (request.keep_picture) outputs.push_back({levels(), "", {}, level(levels())});
}

bool Run::Impl::uses_mask() const { return request.crop || mask || request.metric_nan == NanPolicy::kIgnore; }

void Run::Impl::check_paths() const {
  // The same file by any name: two outputs, or an output and a picture that the metrics read, would destroy one.
  // Writing over the input is what people ask for at times, and safe: it is replaced after it was read.
  std::map<std::filesystem::path, std::string> taken;
  const auto real = [](const std::string& path) {
    std::error_code error;
    const auto found = std::filesystem::weakly_canonical(path, error);
    return error ? std::filesystem::path(path) : found;
  };
  for (const Reference& reference : references)
    taken.emplace(real(reference.path), "the reference '" + reference.path + "'");
  if (!request.mask.empty()) taken.emplace(real(request.mask), "the mask '" + request.mask + "'");
  const auto claim = [&](const std::string& path, const std::string& what) {
    const auto [entry, fresh] = taken.emplace(real(path), what);
    if (!fresh) throw_usage(what + " would overwrite " + entry->second);
  };
  for (const PictureOutput& out : outputs)
    if (!out.path.empty()) claim(out.path, "the output '" + out.path + "'");
  for (const auto& metric : metrics) {
    if (metric->map_path.empty()) continue;
    if (real(metric->map_path) == real(request.input.path))
      throw_usage("the map '" + metric->map_path + "' would overwrite the test picture");
    claim(metric->map_path, "the map '" + metric->map_path + "'");
  }
}

bool Run::Impl::writes_at(const Drive& drive, int at) const {
  if (!drive.writes || at < drive.writes_from || (drive.from_memory && at == drive.first)) return false;
  return std::any_of(outputs.begin(), outputs.end(), [&](const PictureOutput& out) { return out.level == at; });
}

void Run::Impl::add_metrics(PluginHost& host) {
  if (request.metrics.empty()) return;
  const ImageSpec& test = level(levels());
  if (request.crop) {
    const CropRequest& c = *request.crop;
    if (c.x < 0 || c.y < 0 || c.width < 1 || c.height < 1 || c.x > test.width - c.width ||
        c.y > test.height - c.height)
      throw_input("--crop " + std::to_string(c.x) + "," + std::to_string(c.y) + "," + std::to_string(c.width) + "," +
                  std::to_string(c.height) + " does not lie in the test picture '" + request.input.path +
                  "', which is " + test.size_text());
  }
  if (!request.mask.empty()) {
    mask = open_file_source(request.mask, {}, colours);
    if (mask->spec().width != test.width || mask->spec().height != test.height)
      throw_input("--mask '" + request.mask + "' is " + mask->spec().size_text() + ", but the test picture '" +
                  request.input.path + "' is " + test.size_text() + "; a mask has the test picture's size");
  }
  for (const MetricRequest& asked : request.metrics) {
    const StageInfo& info = host.find(asked.item.id);
    if (!info.is_metric()) throw_usage("'" + asked.item.id + "' is a filter; metrics are " + "listed by triad list");
    auto node = std::make_unique<MetricNode>(StageInstance(info, asked.item.params));
    node->label = asked.item.label;
    node->map_path = asked.map_path;
    const triad_desc& desc = *info.desc;
    const auto known = std::find_if(references.begin(), references.end(),
                                    [&](const Reference& r) { return r.path == asked.reference.path; });
    node->reference = static_cast<size_t>(known - references.begin());
    if (!asked.reference.read.colour_space.empty())
      colours.require(asked.reference.read.colour_space, "--ref-from");  // or the message would name --from
    if (known == references.end())
      references.push_back({asked.reference.path, open_source(asked.reference, colours)});
    const ImageSpec& reference = references[node->reference].source->spec();

    // Numbers beside light would give a score that means nothing.
    const auto is_colour = [&](const ImageSpec& spec) {
      return spec.colour_channels > 0 && !spec.colour_space.empty() && !colours.is_data(spec.colour_space);
    };
    if (is_colour(test) != is_colour(reference)) {
      const auto holds = [&](const ImageSpec& spec) {
        return is_colour(spec) ? "colour (" + spec.colour_space + ")" : std::string("values that are no colour");
      };
      warn("'" + request.input.path + "' holds " + holds(test) + " and '" + asked.reference.path + "' " +
           holds(reference) + ": they are compared as they are; --from and --ref-from say what they hold");
    }
    std::vector<triad_image> images(desc.n_inputs);
    std::vector<const triad_image*> given(desc.n_inputs, nullptr);
    std::vector<const Metadata*> metadata(desc.n_inputs, nullptr);
    int pictures = 0;
    for (uint32_t i = 0; i < desc.n_inputs; ++i) {
      const triad_input& declared = *desc.inputs[i];
      if (declared.channels && std::string(declared.channels) == "mask") {
        node->mask_input = static_cast<int>(i);
        if (!uses_mask()) continue;
        images[i] = triad_image{};
        images[i].struct_size = sizeof(triad_image);
        images[i].width = test.width;
        images[i].height = test.height;
        images[i].channels = 1;
        images[i].alpha = -1;
        images[i].cells_x = images[i].cells_y = 1;
        images[i].pixel_aspect = test.pixel_aspect;
      } else if (pictures < 2) {
        const ImageSpec& picture = pictures == 0 ? test : reference;
        InputBinding& binding = pictures == 0 ? node->test_binding : node->reference_binding;
        (pictures == 0 ? node->test_input : node->reference_input) = static_cast<int>(i);
        // Both pictures come in one space: the one the metric asks for, else the user's, else linear light
        // with the test picture's primaries.
        const std::string wanted = declared.space ? declared.space : "";
        std::string space;
        if (pictures == 0 && wanted.empty() && !test.colour_space.empty())
          space = !request.metric_space.empty() ? colours.require(request.metric_space, "--to")
                                                : colours.linear_sibling(test.colour_space);
        if (pictures == 1 && (wanted.empty() || wanted == "linear")) space = node->test_binding.space;
        if (wanted == "display-or-linear")
          space = colours.has_display_codes(test.colour_space) && colours.has_display_codes(reference.colour_space)
                      ? colours.srgb()
                      : colours.lin_rec709();
        binding = bind_input(declared, picture, colours, desc.id, space);
        images[i] = describe_picture(picture, binding, colours);
        metadata[i] = &picture.metadata;
        ++pictures;
      } else if (declared.channels && std::string(declared.channels) == "variance.*") {
        add_variance(desc.id, (declared.flags & TRIAD_INPUT_OPTIONAL) != 0);
        if (!variance) continue;
        node->variance_input = static_cast<int>(i);
        InputBinding as_it_is;
        as_it_is.rgb = true;
        as_it_is.channels = 3;
        images[i] = describe_picture(variance->spec(), as_it_is, colours);
      } else if (declared.flags & TRIAD_INPUT_OPTIONAL) {
        continue;
      } else {
        throw_input("'" + std::string(desc.id) + "' needs the input '" + declared.name +
                    "', which this version cannot give it");
      }
      given[i] = &images[i];
    }
    if (pictures < 2) throw_input("'" + std::string(desc.id) + "' declares no test and reference picture");
    if (node->mask_input < 0 && uses_mask())
      throw_usage("'" + std::string(desc.id) +
                  "' cannot leave pixels out: it takes no --crop, --mask or --nan ignore");
    try {
      node->plan = node->instance.plan(given, metadata);
    } catch (const Error& error) {
      throw Error(error.kind(), std::string(error.what()) + " (test '" + request.input.path + "', reference '" +
                                    asked.reference.path + "')");
    }
    add_map(*node, asked);
    metrics.push_back(std::move(node));
  }
}

void Run::Impl::add_map(MetricNode& node, const MetricRequest& asked) const {
  const ImageSpec& test = level(levels());
  const std::string& id = node.instance.info().id();
  const int channels = node.plan.out.channels;
  if (!node.map_path.empty() && channels == 0)
    throw_usage("'" + id + "' makes no error map; leave --map and --sheet out");
  triad_rect pool = node.plan.plan.pool;
  if (const auto& crop = request.crop)
    pool = {std::max(pool.x0, crop->x), std::max(pool.y0, crop->y), std::min(pool.x1, crop->x + crop->width),
            std::min(pool.y1, crop->y + crop->height)};
  if (request.pool && channels > 0) node.pool = pool;
  if (!asked.pooled_by_name.empty() && !node.pools())
    throw_usage(asked.pooled_by_name + ": '" + id + "' makes no map of errors " +
                (channels > 0 && request.crop ? "inside the crop " : "") +
                "to pool; name one of its own scores, see triad help " + id);
  if (!node.makes_map()) return;
  node.map_spec.width = node.plan.out.width;
  node.map_spec.height = node.plan.out.height;
  if (node.map_spec.width != test.width || node.map_spec.height != test.height)
    throw_internal("'" + id + "' makes a map of another size than its test picture");
  node.map_spec.channels = channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
  node.map_spec.colour_channels = channels;
  node.map_spec.pixel_aspect = test.pixel_aspect;
  if (!node.map_path.empty())
    is_display_encoded_format(node.map_path, Depth::kDefault);  // refuses unknown extensions before the work
}

// The variance of the test picture's pixels lies beside them in their file, and nothing but that file's own pixels
// has it.
void Run::Impl::add_variance(const std::string& metric, bool optional) {
  if (variance) return;
  const std::string wants = "'" + metric + "' needs the variance of the pixels of '" + request.input.path + "'";
  if (levels() > 0) {
    if (optional) return;
    throw_usage(wants + ", which is not that of what '" + filter_texts.front() +
                "' makes of them; compare the file itself, without filters");
  }
  if (request.input.image) {
    if (optional) return;
    throw_input(wants + ", which a picture in memory does not hold; write it with triad render --aov variance, and " +
                "compare the file");
  }
  // Of a layer: NAME.variance.R, or variance.R in the part called NAME.
  const std::string layer = request.input.read.layer;
  std::vector<ReadOptions> places(layer.empty() ? 1 : 2);
  for (ReadOptions& place : places) place.part = request.input.read.part;
  if (layer.empty()) {
    places[0].channels = {"variance.R", "variance.G", "variance.B"};
  } else {
    places[0].layer = layer + ".variance";
    places[1].part = layer;
    places[1].layer = "variance";
  }
  for (const ReadOptions& place : places) try {
      variance = open_file_source(request.input.path, place, colours);
      if (variance->spec().channel_count() == 3) return;
      variance.reset();
    } catch (const Error&) {  // said below
    }
  const std::string prefix = layer.empty() ? "" : layer + ".";
  if (!optional)
    throw_input(wants + ", the channels " + prefix + "variance.R, " + prefix + "variance.G and " + prefix +
                "variance.B, which that file does not have; triad render --aov variance writes them");
}

}  // namespace triad
