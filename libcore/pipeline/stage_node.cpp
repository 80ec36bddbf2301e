// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/stage_node.hpp>

namespace triad {

namespace {
// Channels that stand for colour: those of a picture of three or one channels that are no colour (normals,
// depth) count too, so that such data can be judged and filtered; they are never converted.
int colour_like(const ImageSpec& picture) {
  if (picture.colour_channels > 0) return picture.colour_channels;
  return picture.channel_count() == 3 || picture.channel_count() == 1 ? picture.channel_count() : 0;
}
}  // namespace

InputBinding bind_input(const triad_input& input, const ImageSpec& picture, const ColourConfig& config,
                        const std::string& who, const std::string& space) {
  InputBinding binding;
  const std::string channels = input.channels ? input.channels : "*";
  binding.rgb = channels == "rgb";
  if (!binding.rgb && channels != "*")
    throw_input("'" + who + "': this version cannot give the channels '" + channels + "' to its input '" +
                input.name + "'; it knows 'rgb', '*' and 'mask'");
  if (binding.rgb && colour_like(picture) == 0)
    throw_input("'" + who + "' needs colour, but the picture has only '" + join(picture.channels, "', '") +
                "'; choose colour channels with --channels");
  binding.channels = binding.rgb ? 3 : picture.channel_count();
  binding.space = picture.colour_space;
  const std::string wanted = input.space ? input.space : "";
  // Values that are no colour (data, or a space nobody named) are left as they are.
  if ((wanted.empty() && space.empty()) || picture.colour_channels == 0 || picture.colour_space.empty() ||
      config.is_data(picture.colour_space))
    return binding;
  if (!space.empty())
    binding.space = space;
  else if (wanted == "linear")
    binding.space = config.linear_sibling(picture.colour_space);
  else if (wanted == "linear-rec709")
    binding.space = config.lin_rec709();
  else if (wanted == "display")
    binding.space = config.srgb();
  else
    throw_input("'" + who + "': unknown space '" + wanted + "' of its input '" + input.name +
                "'; there are 'linear', 'linear-rec709', 'display' and, for metrics, 'display-or-linear'");
  binding.transform = config.transform(picture.colour_space, binding.space);
  return binding;
}

triad_image describe_picture(const ImageSpec& picture, const InputBinding& binding, const ColourConfig& config) {
  triad_image image{};
  image.struct_size = sizeof image;
  image.width = picture.width;
  image.height = picture.height;
  image.channels = binding.channels;
  image.alpha = binding.rgb ? -1 : picture.alpha;
  image.cells_x = picture.cells.x;
  image.cells_y = picture.cells.y;
  image.pixel_aspect = picture.pixel_aspect;
  const bool colour = !binding.space.empty() && !config.is_data(binding.space);
  const auto matrix = colour ? config.rgb_to_xyz(config.linear_sibling(binding.space)) : rec709_to_xyz();
  std::copy(matrix.begin(), matrix.end(), image.rgb_to_xyz);
  image.display_codes = config.has_display_codes(binding.space);
  return image;
}

void convert_rows(const StripBuffer& buffer, RowRange rows, const ImageSpec& picture,
                  const ColourTransform& transform) {
  if (transform.identity()) return;
  const int channels = buffer.channels();
  if (picture.colour_channels == 3) {
    for (int y = rows.y0; y < rows.y1; ++y)
      transform.apply(buffer.row(y), static_cast<size_t>(buffer.width()), channels, picture.alpha);
    return;
  }
  // Grey: as r = g = b, beside its alpha.
  const bool alpha = picture.alpha >= 0;
  std::vector<float> wide(static_cast<size_t>(buffer.width()) * 4, 1.0f);
  for (int y = rows.y0; y < rows.y1; ++y) {
    float* row = buffer.row(y);
    for (int x = 0; x < buffer.width(); ++x) {
      const float* pixel = row + static_cast<size_t>(x) * channels;
      std::fill_n(&wide[static_cast<size_t>(x) * 4], 3, pixel[0]);
      if (alpha) wide[static_cast<size_t>(x) * 4 + 3] = pixel[picture.alpha];
    }
    transform.apply(wide.data(), static_cast<size_t>(buffer.width()), 4, alpha ? 3 : -1);
    for (int x = 0; x < buffer.width(); ++x)
      row[static_cast<size_t>(x) * channels] = wide[static_cast<size_t>(x) * 4 + 1];
  }
}

namespace {
bool same_channels(const ImageSpec& picture, const InputBinding& binding) {
  return !binding.rgb || (colour_like(picture) == 3 && picture.channel_count() == 3);
}
void copy_rows(const StripBuffer& from, const StripBuffer& to) {
  const RowRange rows = from.rows();
  for (int y = rows.y0; y < rows.y1; ++y)
    std::memcpy(to.row(y), from.row(y), static_cast<size_t>(from.width()) * from.channels() * sizeof(float));
}
}  // namespace

uint64_t prepare_bytes(RowRange rows, const Pads& pads, bool may_modify, const ImageSpec& picture,
                       const InputBinding& binding) {
  const bool same = same_channels(picture, binding);
  uint64_t bytes = 0;
  if (!binding.transform.identity() && !may_modify)
    bytes += StripBuffer::bytes(rows, picture.width, picture.channel_count(), pads);
  if (!same) bytes += StripBuffer::bytes(rows, picture.width, 3, pads);
  return bytes;
}

StripBuffer prepare_input(BufferPool& pool, const StripBuffer& in, bool may_modify, const ImageSpec& picture,
                          const InputBinding& binding) {
  StripBuffer source = in;
  if (!binding.transform.identity()) {
    if (!may_modify) {
      source = StripBuffer(pool, in.rows(), in.width(), in.channels(), in.pads());
      copy_rows(in, source);
    }
    convert_rows(source, source.rows(), picture, binding.transform);
  }
  if (same_channels(picture, binding)) return source;
  const StripBuffer rgb(pool, in.rows(), in.width(), 3, in.pads());
  const bool grey = colour_like(picture) == 1;
  for (int y = in.rows().y0; y < in.rows().y1; ++y) {
    const float* from = source.row(y);
    float* to = rgb.row(y);
    for (int x = 0; x < in.width(); ++x, from += source.channels(), to += 3) {
      to[0] = from[0];
      to[1] = from[grey ? 0 : 1];
      to[2] = from[grey ? 0 : 2];
    }
  }
  return rgb;
}

FilterNode::FilterNode(StageInstance instance, const ImageSpec& in, const ColourConfig& config)
    : instance_(std::move(instance)), in_(in), out_(in) {
  const triad_desc& desc = *instance_.info().desc;
  const std::string who = desc.id;
  for (uint32_t i = 1; i < desc.n_inputs; ++i)
    if (!(desc.inputs[i]->flags & TRIAD_INPUT_OPTIONAL))
      throw_input("'" + who + "' needs a second picture ('" + desc.inputs[i]->name +
                  "'), which a filter in a chain cannot be given");
  binding_ = bind_input(*desc.inputs[0], in, config, who);
  const triad_image image = describe_picture(in, binding_, config);
  std::vector<const triad_image*> images(desc.n_inputs, nullptr);
  std::vector<const Metadata*> metadata(desc.n_inputs, nullptr);
  images[0] = &image;
  metadata[0] = &in.metadata;
  plan_ = instance_.plan(images, metadata);
  if (plan_.out.channels < 1) throw_input("'" + who + "' gives no picture, though it calls itself a filter");

  out_.width = plan_.out.width;
  out_.height = plan_.out.height;
  out_.cells = {plan_.out.cells_x, plan_.out.cells_y};
  out_.pixel_aspect = plan_.out.pixel_aspect;
  if (out_.colour_space != binding_.space) out_.chromaticities.reset();
  out_.colour_space = binding_.space;
  out_.metadata = plan_.metadata;
  const bool same_size = out_.width == in.width && out_.height == in.height;
  if (plan_.out.channels != binding_.channels || binding_.rgb) {
    static const std::vector<std::string> kRgb{"R", "G", "B"};
    out_.channels.clear();
    out_.alpha = plan_.out.alpha;
    out_.colour_channels = plan_.out.channels >= 3 ? 3 : 1;
    for (int c = 0; c < plan_.out.channels; ++c)
      out_.channels.push_back(plan_.out.channels == 1           ? "Y"
                              : c == plan_.out.alpha            ? "A"
                              : c < 3 && plan_.out.channels > 2 ? kRgb[static_cast<size_t>(c)]
                                                                : "channel" + std::to_string(c));
    if (binding_.rgb && colour_like(in) == 3 && plan_.out.channels == 3)
      std::copy_n(in.channels.begin(), 3, out_.channels.begin());
  }
  if (!binding_.rgb) return;

  const bool blocks = in.width % out_.width == 0 && in.height % out_.height == 0;
  std::vector<std::string> dropped;
  for (int c = colour_like(in); c < in.channel_count(); ++c) {
    const bool alpha = c == in.alpha;
    if (same_size || (alpha && blocks)) {
      if (alpha) out_.alpha = out_.channel_count();
      out_.channels.push_back(in.channels[static_cast<size_t>(c)]);
      bypass_.push_back(c);
    } else {
      dropped.push_back(in.channels[static_cast<size_t>(c)]);
    }
  }
  scale_x_ = same_size ? 1 : std::max(1, in.width / out_.width);
  scale_y_ = same_size ? 1 : std::max(1, in.height / out_.height);
  if (!dropped.empty())
    warn("'" + who + "' changes the picture's size; dropped the channel" + (dropped.size() > 1 ? "s '" : " '") +
         join(dropped, "', '") + "'");
}

StripNeeds FilterNode::needs(int pass, RowRange out) const {
  StripNeeds needs;
  const int strip = plan_.plan.strip_rows;
  int step = out.y1 - out.y0;
  if (strip > 0) {
    out.y0 = out.y0 / strip * strip;
    out.y1 =
        static_cast<int>(std::min<int64_t>(out_.height, (static_cast<int64_t>(out.y1) + strip - 1) / strip * strip));
    step = strip;
  } else if (strip < 0) {
    out = {0, out_.height};
    step = out_.height;
  }
  needs.out = out;
  for (int y = out.y0; y < out.y1; y += step) {
    const RowRange rows{y, std::min(out.y1, y + step)};
    const triad_rect rect = instance_.need(pass, {0, rows.y0, out_.width, rows.y1})[0];
    needs.calls.push_back({rows, rect});
    needs.in.cover(row_hull(rect, in_.height, plan_.plan.edge));
  }
  if (!bypass_.empty()) needs.in.cover({out.y0 * scale_y_, std::min(in_.height, out.y1 * scale_y_)});
  for (const auto& call : needs.calls) needs.pads.cover(overhang(call.need, in_.width, needs.in));
  return needs;
}

StripBuffer FilterNode::view_of(BufferPool& pool, const StripBuffer& in, const StripNeeds& needs,
                                bool may_modify) const {
  const bool passes_by = !bypass_.empty();
  const bool zero = plan_.plan.nonfinite == TRIAD_NONFINITE_ZERO;
  StripBuffer view = prepare_input(pool, in, may_modify && !passes_by, in_, binding_);
  // Replacing values in place must not reach whoever else reads this picture.
  if (zero && !may_modify && view.row(needs.in.y0) == in.row(needs.in.y0)) {
    const StripBuffer own(pool, in.rows(), in.width(), in.channels(), in.pads());
    copy_rows(view, own);
    return own;
  }
  return view;
}

uint64_t FilterNode::run_bytes(const StripNeeds& needs, bool may_modify) const {
  const bool passes_by = !bypass_.empty();
  uint64_t bytes = prepare_bytes(needs.in, needs.pads, may_modify && !passes_by, in_, binding_);
  if (bytes == 0 && !may_modify && plan_.plan.nonfinite == TRIAD_NONFINITE_ZERO)
    bytes = StripBuffer::bytes(needs.in, in_.width, in_.channel_count(), needs.pads);
  if (passes_by) bytes += StripBuffer::bytes(needs.out, out_.width, plan_.out.channels, {});
  return bytes + plan_.plan.work_bytes;
}

StripBuffer FilterNode::run(BufferPool& pool, const StripBuffer& in, const StripNeeds& needs, const Pads& out_pads,
                            int fresh_y, int fresh_out_y, bool may_modify, NonFinite& replaced,
                            std::vector<StageState>& states) {
  StripBuffer view = view_of(pool, in, needs, may_modify);
  if (plan_.plan.nonfinite == TRIAD_NONFINITE_ZERO)
    for (int y = needs.in.y0; y < needs.in.y1; ++y) {
      const NonFinite found = zero_nonfinite(view.row(y), static_cast<size_t>(view.width()) * view.channels());
      if (y >= fresh_y) replaced += found;
    }
  StripBuffer out(pool, needs.out, out_.width, out_.channel_count(), out_pads);
  const StripBuffer made = bypass_.empty() ? out : StripBuffer(pool, needs.out, out_.width, plan_.out.channels, {});
  const int last = plan_.plan.passes - 1;
  std::vector<const triad_strip*> inputs(instance_.info().desc->n_inputs, nullptr);
  for (const auto& call : needs.calls) {
    fill_edges(view, call.need, in_.height, plan_.plan.edge);
    const auto make = [&](triad_rect rect, triad_rect need) {
      const triad_strip in_strip = view.view(need), out_strip = made.view(rect);
      inputs[0] = &in_strip;
      StageState state(plan_.plan.state_bytes);
      instance_.strip(last, rect, inputs, &out_strip, state.data());
      if (plan_.plan.state_bytes > 0 && rect.y0 >= fresh_out_y) states.push_back(std::move(state));
    };
    const triad_rect rect{0, call.out.y0, out_.width, call.out.y1};
    const bool divided =
        plan_.plan.state_bytes > 0 && plan_.plan.strip_rows == 0 && rect.y0 < fresh_out_y && fresh_out_y < rect.y1;
    if (divided) {
      const triad_rect seen{0, rect.y0, rect.x1, fresh_out_y}, fresh{0, fresh_out_y, rect.x1, rect.y1};
      make(seen, instance_.need(last, seen)[0]);
      make(fresh, instance_.need(last, fresh)[0]);
    } else {
      make(rect, call.need);
    }
  }
  if (!bypass_.empty()) pass_by(in, made, out, needs.out);
  return out;
}

void FilterNode::run_pass(BufferPool& pool, int pass, const StripBuffer& in, const StripNeeds& needs, bool may_modify,
                          std::vector<StageState>& states) {
  StripBuffer view = view_of(pool, in, needs, may_modify);
  if (plan_.plan.nonfinite == TRIAD_NONFINITE_ZERO)
    for (int y = needs.in.y0; y < needs.in.y1; ++y)
      zero_nonfinite(view.row(y), static_cast<size_t>(view.width()) * view.channels());
  std::vector<const triad_strip*> inputs(instance_.info().desc->n_inputs, nullptr);
  for (const auto& call : needs.calls) {
    fill_edges(view, call.need, in_.height, plan_.plan.edge);
    const triad_strip in_strip = view.view(call.need);
    inputs[0] = &in_strip;
    states.emplace_back(plan_.plan.state_bytes);
    instance_.strip(pass, {0, call.out.y0, out_.width, call.out.y1}, inputs, nullptr, states.back().data());
  }
}

void FilterNode::pass_by(const StripBuffer& in, const StripBuffer& made, const StripBuffer& out,
                         RowRange rows) const {
  const int made_channels = made.channels(), channels = out.channels();
  const double share = 1.0 / (static_cast<double>(scale_x_) * scale_y_);
  for (int y = rows.y0; y < rows.y1; ++y) {
    float* to = out.row(y);
    const float* from = made.row(y);
    for (int x = 0; x < out_.width; ++x, to += channels, from += made_channels) {
      std::copy_n(from, made_channels, to);
      for (size_t k = 0; k < bypass_.size(); ++k) {
        double sum = 0;
        for (int v = 0; v < scale_y_; ++v) {
          const float* block =
              in.row(y * scale_y_ + v) + (static_cast<size_t>(x) * scale_x_) * in.channels() + bypass_[k];
          for (int u = 0; u < scale_x_; ++u) sum += block[static_cast<size_t>(u) * in.channels()];
        }
        to[made_channels + static_cast<int>(k)] = static_cast<float>(sum * share);
      }
    }
  }
}

}  // namespace triad
