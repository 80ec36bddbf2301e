// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/run_impl.hpp>

namespace triad {
namespace {

// A strip's rows are chosen so that its widest level is about this large: small enough to stay in a
// last-level cache with its neighbours, large enough that reading by blocks pays.
constexpr uint64_t kStripBytes = 2u << 20;
constexpr int kMinStripRows = 16, kMaxStripRows = 1024;
// A stage whose needs make its input's rows come this many times is given them from memory.
constexpr double kRecomputeLimit = 2.0;
// What the program and its libraries hold, code included; measured as the resident size with a 1 x 1 picture.
constexpr uint64_t kBaseBytes = 144u << 20;
// A picture that is written and then cropped makes its strips longer; past this factor it is written by a drive
// of its own.
constexpr uint64_t kUnevenLimit = 2;

uint64_t picture_bytes(const ImageSpec& spec) {
  return static_cast<uint64_t>(spec.width) * spec.height * spec.channels.size() * sizeof(float);
}

bool keeps_all_channels(const std::string& path) {
  const std::string name = lower(path);
  return name.ends_with(".exr") || name.ends_with(".tif") || name.ends_with(".tiff");
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

void Run::Impl::open_input() { input = open_file_source(request.input.path, request.input.read, colours); }

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
  if (everything && request.input.read.channels.empty()) {
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
  for (const PictureOutput& out : outputs) claim(out.path, "the output '" + out.path + "'");
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
      throw_usage("--crop " + std::to_string(c.x) + "," + std::to_string(c.y) + "," + std::to_string(c.width) + "," +
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
      references.push_back(
          {asked.reference.path, open_file_source(asked.reference.path, asked.reference.read, colours)});
    const ImageSpec& reference = references[node->reference].source->spec();

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
        binding = bind_input(declared, picture, colours, desc.id, space);
        images[i] = describe_picture(picture, binding, colours);
        metadata[i] = &picture.metadata;
        ++pictures;
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
    if (!node->map_path.empty()) {
      if (node->plan.out.channels == 0)
        throw_usage("'" + std::string(desc.id) + "' makes no error map; leave --map out");
      node->map_spec.width = node->plan.out.width;
      node->map_spec.height = node->plan.out.height;
      if (node->map_spec.width != test.width || node->map_spec.height != test.height)
        throw_internal("'" + std::string(desc.id) + "' makes a map of another size than its test picture");
      static const std::vector<std::string> kNames{"R", "G", "B", "A"};
      const int channels = node->plan.out.channels;
      for (int c = 0; c < channels; ++c)
        node->map_spec.channels.push_back(channels == 1 ? "Y"
                                          : c < 4       ? kNames[static_cast<size_t>(c)]
                                                        : std::to_string(c));
      node->map_spec.colour_channels = channels >= 3 ? 3 : 1;
      node->map_spec.pixel_aspect = test.pixel_aspect;
      is_display_encoded_format(node->map_path, Depth::kDefault);  // refuses unknown extensions before the work
    }
    metrics.push_back(std::move(node));
  }
}

void Run::Impl::plan_drives() {
  int first = 0;
  bool held = false;  // whether level `first` is in memory
  const auto push = [&](int last, Sink sink, int pass, int sink_height) {
    Drive drive;
    drive.first = first;
    drive.last = last;
    drive.sink = sink;
    drive.pass = pass;
    drive.from_memory = held;
    drive.writes = sink != Sink::kPass && pass == 0;
    drive.sink_height = sink_height;
    drives.push_back(drive);
  };
  const auto hold = [&](int at) {
    push(at, Sink::kHold, 0, level(at).height);
    first = at;
    held = true;
  };
  for (int i = 0; i < levels(); ++i) {
    const FilterNode& filter = *filters[static_cast<size_t>(i)];
    const bool whole = filter.plan().strip_rows < 0;
    // How often each input row would be asked for, and whether the needs only ever move down.
    bool costly = false;
    if (!whole) {
      uint64_t asked = 0;
      RowRange before{0, 0};
      const int height = filter.out().height, step = std::min(height, kMetricStripRows);
      for (int y = 0; y < height && !costly; y += step) {
        const RowRange rows = filter.needs(filter.plan().passes - 1, {y, std::min(height, y + step)}).in;
        asked += static_cast<uint64_t>(rows.y1 - rows.y0);
        costly = rows.y0 < before.y0 || rows.y1 < before.y1;
        before = rows;
      }
      costly = costly || static_cast<double>(asked) > kRecomputeLimit * level(i).height + kMetricStripRows;
    }
    if ((whole || costly) && (i > first || (costly && !held))) {
      hold(i);
    }
    for (int pass = 0; pass + 1 < filter.plan().passes; ++pass) push(i, Sink::kPass, pass, filter.out().height);
    if (whole) {
      hold(i + 1);
    } else if (filter.plan().threads == TRIAD_SERIAL && i + 1 < levels()) {
      // A serial stage sees each of its strips once: the next stage may not ask for rows again, however the
      // picture is cut, down to single rows.
      const FilterNode& next = *filters[static_cast<size_t>(i) + 1];
      uint64_t asked = 0;
      for (int y = 0; y < next.out().height; ++y) {
        const RowRange rows = next.needs(next.plan().passes - 1, {y, y + 1}).in;
        asked += static_cast<uint64_t>(rows.y1 - rows.y0);
      }
      if (asked != static_cast<uint64_t>(level(i + 1).height) || next.plan().passes > 1) {
        hold(i + 1);
      }
    }
  }
  int passes = 1;
  bool whole_metric = false, overlapping = false;
  for (const auto& metric : metrics) {
    passes = std::max(passes, metric->plan.plan.passes);
    whole_metric = whole_metric || metric->plan.plan.strip_rows < 0;
    overlapping = true;
  }
  const bool serial_before =
      levels() > first && std::any_of(filters.begin() + first, filters.end(),
                                      [](const auto& f) { return f->plan().threads == TRIAD_SERIAL; });
  if (levels() > first && (whole_metric || (serial_before && overlapping))) hold(levels());
  const int uneven = uneven_level(first);
  if (uneven >= first && !(held && uneven == first)) {
    // A serial stage runs once only; what it made is then kept.
    if (std::any_of(filters.begin() + first, filters.begin() + uneven,
                    [](const auto& f) { return f->plan().threads == TRIAD_SERIAL; }))
      hold(uneven);
    else
      push(uneven, Sink::kWrite, 0, level(uneven).height);
  }
  for (int pass = 0; pass < passes; ++pass) {
    push(levels(), Sink::kFinal, pass, level(levels()).height);
    drives.back().writes_from = uneven + 1;
  }
}

// Outputs at a level of which later stages look at a part only (a crop): one strip would have to hold all the
// rest. They get a drive of their own, at the price of running the stages before them twice.
int Run::Impl::uneven_level(int first) const {
  int uneven = -1;
  for (int at = first; at < levels(); ++at) {
    if (std::none_of(outputs.begin(), outputs.end(), [&](const PictureOutput& o) { return o.level == at; })) continue;
    RowRange rows{0, level(levels()).height};
    for (int i = levels() - 1; i >= at; --i)
      rows = filters[static_cast<size_t>(i)]->needs(filters[static_cast<size_t>(i)]->plan().passes - 1, rows).in;
    if (level(at).height > static_cast<int64_t>(kUnevenLimit) * (rows.y1 - rows.y0)) uneven = at;
  }
  return uneven;
}

void Run::Impl::choose_rows(Drive& drive, int rows) const {
  // Whole strips of everything at the sink: a metric's fixed heights must not straddle two tokens.
  int64_t unit = 1;
  if (drive.sink == Sink::kFinal)
    for (const auto& metric : metrics)
      unit = std::lcm(unit, static_cast<int64_t>(metric->strip_rows(drive.sink_height)));
  if (drive.sink == Sink::kPass) {
    const int strip = filters[static_cast<size_t>(drive.last)]->plan().strip_rows;
    unit = strip < 0 ? drive.sink_height : std::max(1, strip);
  }
  if (drive.sink == Sink::kHold && drive.last > drive.first &&
      filters[static_cast<size_t>(drive.last) - 1]->plan().strip_rows < 0)
    unit = drive.sink_height;
  unit = std::min<int64_t>(unit, drive.sink_height);
  const int64_t rounded = (static_cast<int64_t>(rows) + unit - 1) / unit * unit;
  drive.token_rows = static_cast<int>(std::clamp<int64_t>(rounded, 1, std::max(1, drive.sink_height)));
}

std::vector<TokenPlan> Run::Impl::plan_tokens(const Drive& drive) const {
  std::vector<TokenPlan> tokens;
  const size_t count = static_cast<size_t>(drive.last - drive.first) + 1;
  std::vector<int> covered(count, 0);
  for (int64_t n = 0; n < drive.tokens(); ++n) {
    TokenPlan token;
    const int y0 = static_cast<int>(n * drive.token_rows);
    token.sink = {
        y0, static_cast<int>(std::min<int64_t>(drive.sink_height, static_cast<int64_t>(y0) + drive.token_rows))};
    token.rows.resize(count);
    token.pads.resize(count);
    token.stages.resize(count - 1);
    token.reference_rows.resize(references.size());
    token.reference_pads.resize(references.size());
    RowRange rows = token.sink;
    Pads pads;
    if (drive.sink == Sink::kPass) {
      token.stages.push_back(filters[static_cast<size_t>(drive.last)]->needs(drive.pass, token.sink));
      rows = token.stages.back().in;
      pads = token.stages.back().pads;
    } else if (drive.sink == Sink::kFinal) {
      for (const auto& metric : metrics) {
        std::vector<MetricCall> calls;
        if (drive.pass < metric->plan.plan.passes) {
          const int step = metric->strip_rows(drive.sink_height), edge = metric->plan.plan.edge;
          const int width = level(levels()).width;
          for (int y = token.sink.y0; y < token.sink.y1; y += step) {
            MetricCall call;
            call.out = {y, std::min(token.sink.y1, y + step)};
            call.needs = metric->instance.need(drive.pass, {0, call.out.y0, width, call.out.y1});
            rows.cover(row_hull(call.needs[static_cast<size_t>(metric->test_input)], drive.sink_height, edge));
            token.reference_rows[metric->reference].cover(
                row_hull(call.needs[static_cast<size_t>(metric->reference_input)],
                         references[metric->reference].source->spec().height, edge));
            if (metric->mask_input >= 0 && uses_mask())
              token.mask_rows.cover(
                  row_hull(call.needs[static_cast<size_t>(metric->mask_input)], drive.sink_height, edge));
            calls.push_back(std::move(call));
          }
        }
        token.metrics.push_back(std::move(calls));
      }
      // The weights of --nan ignore look at the test and the reference.
      if (!token.mask_rows.empty()) rows.cover(token.mask_rows);
      for (size_t m = 0; m < metrics.size(); ++m)
        for (const MetricCall& call : token.metrics[m]) {
          const auto& metric = *metrics[m];
          const ImageSpec& test = level(levels());
          const ImageSpec& reference = references[metric.reference].source->spec();
          pads.cover(overhang(call.needs[static_cast<size_t>(metric.test_input)], test.width, rows));
          token.reference_pads[metric.reference].cover(
              overhang(call.needs[static_cast<size_t>(metric.reference_input)], reference.width,
                       token.reference_rows[metric.reference]));
          if (metric.mask_input >= 0 && uses_mask())
            token.mask_pads.cover(
                overhang(call.needs[static_cast<size_t>(metric.mask_input)], test.width, token.mask_rows));
        }
    }
    for (int at = drive.last;; --at) {
      const size_t k = static_cast<size_t>(at - drive.first);
      if (writes_at(drive, at)) {
        // A picture that is written needs each of its rows, in order, whatever the stages after it look at.
        rows.y0 = std::min(rows.y0, covered[k]);
        if (n + 1 == drive.tokens()) rows.y1 = level(at).height;
        rows.y1 = std::max(rows.y1, covered[k]);
      }
      token.rows[k] = rows;
      token.pads[k] = pads;
      if (at == drive.first) break;
      token.stages[k - 1] =
          filters[static_cast<size_t>(at) - 1]->needs(filters[static_cast<size_t>(at) - 1]->plan().passes - 1, rows);
      token.rows[k] = token.stages[k - 1].out;
      rows = token.stages[k - 1].in;
      pads = token.stages[k - 1].pads;
    }
    token.fresh = covered;
    for (size_t k = 0; k < count; ++k) covered[k] = std::max(covered[k], token.rows[k].y1);
    token.bytes = estimate(drive, token);
    tokens.push_back(std::move(token));
  }
  return tokens;
}

uint64_t Run::Impl::estimate(const Drive& drive, const TokenPlan& token) const {
  const auto bytes_at = [&](int at) {
    const size_t k = static_cast<size_t>(at - drive.first);
    return StripBuffer::bytes(token.rows[k], level(at).width, level(at).channel_count(), token.pads[k]);
  };
  const auto copies_at = [&](int at) -> uint64_t {
    if (!writes_at(drive, at)) return 0;
    return static_cast<uint64_t>(
        std::count_if(outputs.begin(), outputs.end(), [&](const PictureOutput& o) { return o.level == at; }));
  };
  uint64_t held = 0, peak = 0;  // held: references, mask, and copies that wait to be written
  for (size_t r = 0; r < references.size(); ++r) {
    const ImageSpec& spec = references[r].source->spec();
    if (!token.reference_rows[r].empty())
      held += StripBuffer::bytes(token.reference_rows[r], spec.width, spec.channel_count(), token.reference_pads[r]);
  }
  if (!token.mask_rows.empty())
    held += StripBuffer::bytes(token.mask_rows, level(levels()).width, 1, token.mask_pads);
  uint64_t current = bytes_at(drive.first);
  peak = held + current;
  for (int at = drive.first; at < drive.last; ++at) {
    held += copies_at(at) * current;
    const FilterNode& filter = *filters[static_cast<size_t>(at)];
    const uint64_t next = bytes_at(at + 1);
    peak = std::max(
        peak, held + current + filter.run_bytes(token.stages[static_cast<size_t>(at - drive.first)], true) + next);
    current = next;
  }
  if (drive.sink == Sink::kPass)
    peak = std::max(peak,
                    held + current + filters[static_cast<size_t>(drive.last)]->run_bytes(token.stages.back(), true));
  if (drive.sink == Sink::kFinal) {
    if (!metrics.empty()) held += copies_at(drive.last) * current;
    uint64_t maps = 0, copies = 0;
    for (const auto& metric : metrics) {
      if (!metric->map_path.empty())
        maps += StripBuffer::bytes(token.sink, metric->map_spec.width, metric->map_spec.channel_count(), {});
      const size_t r = metric->reference;
      const ImageSpec& spec = references[r].source->spec();
      // Each metric has a copy of its own of both, unless it takes them as they are.
      copies =
          std::max(copies, current + StripBuffer::bytes(token.reference_rows[r], spec.width,
                                                        std::max(3, spec.channel_count()), token.reference_pads[r]));
    }
    peak = std::max(peak, held + current + maps + copies);
  }
  return peak;
}

void Run::Impl::fit_memory() {
  const uint64_t limit = request.max_memory ? request.max_memory
                                            : static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                                                  static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) / 2;
  uint64_t fixed = kBaseBytes + input->memory_bytes();
  for (const Reference& reference : references) fixed += reference.source->memory_bytes();
  // Encoders hold some blocks of rows: about three of 64 rows, measured over the formats.
  for (const PictureOutput& out : outputs)
    fixed += (1u << 20) + uint64_t{3} * 64 * out.spec.width * out.spec.channels.size() * sizeof(float);
  // A held picture lives until the drive after the one that reads it: count the worst pair.
  uint64_t held_before = 0;
  peak_bytes = 0;
  for (Drive& drive : drives) {
    uint64_t widest = 1;
    for (int at = drive.first; at <= drive.last; ++at) {
      // Rows of this level for each row of the sink.
      const double ratio = static_cast<double>(level(at).height) / std::max(1, drive.sink_height);
      const double bytes = static_cast<double>(level(at).width) * level(at).channel_count() * sizeof(float) * ratio;
      widest = std::max(widest, static_cast<uint64_t>(bytes) + 1);
    }
    const uint64_t base = fixed + held_before + (drive.sink == Sink::kHold ? picture_bytes(level(drive.last)) : 0);
    int rows = request.strip_rows;
    if (rows == 0) rows = static_cast<int>(std::clamp<uint64_t>(kStripBytes / widest, kMinStripRows, kMaxStripRows));
    const auto measure = [&] {
      drive.token_bytes = 0;
      for (const TokenPlan& token : plan_tokens(drive)) drive.token_bytes = std::max(drive.token_bytes, token.bytes);
    };
    choose_rows(drive, rows);
    measure();
    // One more strip than threads, so that reading goes on while all of them compute.
    drive.in_flight = static_cast<int>(std::min<int64_t>(drive.tokens(), thread_limit() + 1));
    while (base + drive.in_flight * drive.token_bytes > limit) {
      const int before = drive.token_rows;
      if (request.strip_rows == 0 && drive.token_rows > 1) {
        choose_rows(drive, std::max(1, drive.token_rows / 2));
        measure();
      }
      if (drive.token_rows == before) {
        if (drive.in_flight == 1) {
          const uint64_t least = base + drive.token_bytes;
          throw_input("this chain needs " + format_bytes(least) + " for '" + request.input.path + "', but only " +
                      format_bytes(limit) + " may be used; --max-memory " + std::to_string((least >> 20) + 1) +
                      "M would do");
        }
        --drive.in_flight;
      }
    }
    peak_bytes = std::max(peak_bytes, base + drive.in_flight * drive.token_bytes);
    if (drive.sink == Sink::kHold) held_before = picture_bytes(level(drive.last));
  }
  if (peak_bytes < fixed) peak_bytes = fixed;
}

}  // namespace triad
