// SPDX-License-Identifier: Apache-2.0
#include "compare_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/image/writer.hpp>
#include <triad/pipeline/picture_source.hpp>

#include "small_digits.hpp"

namespace triad::app {
namespace {

constexpr int kStripRows = 64;
constexpr int kGap_px = 8;            // between panels
constexpr float kPaper = 46.f / 255;  // code of what is behind the panels
constexpr int kBarRows = 12, kLegendRows = kGap_px + kBarRows + 4 + kDigitRows + 4;

ImageSpec picture_spec(int width, int height) {
  ImageSpec spec;
  spec.width = width;
  spec.height = height;
  spec.channels = {"R", "G", "B"};
  spec.colour_channels = 3;
  spec.colour_space = "sRGB";
  return spec;
}

std::string scale_text(const MapScale& scale) { return format_double(scale.low) + ":" + format_double(scale.high); }

// Rows of one panel as sRGB values, ascending.
class Panel {
 public:
  virtual ~Panel() = default;
  virtual int width() const = 0;
  virtual int height() const = 0;
  // rows * width() * 3 values; rows that the panel does not have are left alone.
  virtual void rows(int y0, int y1, float* out, size_t row_stride) = 0;
};

class MapPanel final : public Panel {
 public:
  explicit MapPanel(const ShownMap& map)
      : scale_(map.scale), table_(colour_table(map.colours)), reader_(ImageReader::open(map.file)) {}
  int width() const override { return reader_->spec().width; }
  int height() const override { return reader_->spec().height; }

  void means(int y0, int y1, std::vector<float>& out) {
    const size_t channels = reader_->spec().channels.size(), count = static_cast<size_t>(y1 - y0) * pixels();
    buffer_.resize(count * channels);
    out.resize(count);
    reader_->read_rows(y0, y1, buffer_.data(), pixels() * channels);
    for (size_t i = 0; i < count; ++i) {
      double sum = 0;
      for (size_t c = 0; c < channels; ++c) sum += static_cast<double>(buffer_[i * channels + c]);
      out[i] = static_cast<float>(sum / static_cast<double>(channels));
    }
  }

  void rows(int y0, int y1, float* out, size_t row_stride) override {
    y1 = std::min(y1, height());
    if (y0 >= y1) return;
    means(y0, y1, values_);
    for (int y = y0; y < y1; ++y)
      for (size_t x = 0; x < pixels(); ++x) {
        const size_t row = static_cast<size_t>(y - y0);
        const ColourCode code = map_colour(table_, scale_, static_cast<double>(values_[row * pixels() + x]));
        for (size_t c = 0; c < 3; ++c) out[row * row_stride + 3 * x + c] = static_cast<float>(code[c]) / 255.f;
      }
  }

 private:
  size_t pixels() const { return static_cast<size_t>(width()); }

  MapScale scale_;
  const std::array<ColourCode, 256>& table_;
  std::unique_ptr<ImageReader> reader_;
  std::vector<float> buffer_, values_;
};

float bend(float x) {
  constexpr float kKnee = .75f, kRest = 1 - kKnee;
  if (!(x > kKnee)) return std::max(x, 0.f);  // NaN becomes 0
  if (std::isinf(x)) return 1;
  const float t = x - kKnee;
  return kKnee + kRest * t / (t + kRest);
}

class PicturePanel final : public Panel {
 public:
  PicturePanel(const PictureRequest& picture, const ColourConfig& colours, double exposure_ev)
      : source_(picture.image ? memory_source(*picture.image)
                              : open_file_source(picture.path, picture.read, colours)),
        gain_(static_cast<float>(std::exp2(exposure_ev))) {
    const std::string& space = spec().colour_space;
    codes_ = colours.has_display_codes(space);
    if (!space.empty() && !colours.is_data(space)) to_linear_ = colours.transform(space, colours.lin_rec709());
    to_codes_ = colours.transform(colours.lin_rec709(), colours.srgb());
  }
  const ImageSpec& spec() const { return source_->spec(); }
  bool display_codes() const { return codes_; }
  int width() const override { return spec().width / block_x_; }
  int height() const override { return spec().height / block_y_; }

  void set_bend(bool bend) { bend_ = bend; }
  // Averages blocks of cells, if the picture is whole multiples of that size.
  void reduce_to(int pixels_x, int pixels_y) {
    if (spec().width % pixels_x != 0 || spec().height % pixels_y != 0) return;
    block_x_ = spec().width / pixels_x;
    block_y_ = spec().height / pixels_y;
  }

  void rows(int y0, int y1, float* out, size_t row_stride) override {
    y1 = std::min(y1, height());
    for (int y = y0; y < y1; ++y) row(y, out + static_cast<size_t>(y - y0) * row_stride);
  }

 private:
  void row(int y, float* out) {
    const size_t cells = static_cast<size_t>(spec().width), channels = spec().channels.size();
    const size_t count = static_cast<size_t>(width()), block = static_cast<size_t>(block_x_);
    std::fill_n(out, count * 3, 0.f);
    const float share = 1 / static_cast<float>(block_x_ * block_y_);
    for (int part = 0; part < block_y_; ++part) {
      read(y * block_y_ + part);
      const float* from = block_.data() + static_cast<size_t>(y * block_y_ + part - first_) * cells * channels;
      rgb_.resize(cells * 3);
      const bool grey = spec().colour_channels == 1 || channels < 3;
      for (size_t x = 0; x < cells; ++x)
        for (size_t c = 0; c < 3; ++c) rgb_[3 * x + c] = from[x * channels + (grey ? 0 : c)];
      to_linear_.apply(rgb_.data(), cells, 3, -1);
      for (size_t x = 0; x < count; ++x)
        for (size_t b = 0; b < block; ++b)
          for (size_t c = 0; c < 3; ++c) out[3 * x + c] += rgb_[3 * (x * block + b) + c] * share;
    }
    for (size_t i = 0; i < count * 3; ++i) {
      const float light = out[i] * gain_;
      out[i] = bend_ ? bend(light) : std::clamp(light, 0.f, 1.f);
    }
    to_codes_.apply(out, count, 3, -1);
  }

  // Makes row y one of those in block_; rows come in ascending order.
  void read(int y) {
    if (y >= first_ && y < first_ + held_) return;
    first_ = y;
    held_ = std::min(kStripRows, spec().height - y);
    const size_t stride = static_cast<size_t>(spec().width) * spec().channels.size();
    block_.resize(stride * static_cast<size_t>(held_));
    source_->read_rows({first_, first_ + held_}, block_.data(), stride);
  }

  std::unique_ptr<PictureSource> source_;
  float gain_ = 1;
  bool codes_ = false, bend_ = false;
  int block_x_ = 1, block_y_ = 1, first_ = 0, held_ = 0;
  ColourTransform to_linear_, to_codes_;
  std::vector<float> block_, rgb_;
};

// The rows below the panels: for each map a bar of its colours, and at its ends what they stand for.
class Legend {
 public:
  explicit Legend(size_t row_floats) : rows_(row_floats * kLegendRows, kPaper), row_floats_(row_floats) {}

  void add(const ShownMap& map, int x0, int width) {
    const auto& table = colour_table(map.colours);
    for (int x = 0; x < width; ++x) {
      const ColourCode code = table[static_cast<size_t>(width > 1 ? (x * 255 + (width - 1) / 2) / (width - 1) : 255)];
      for (int y = kGap_px; y < kGap_px + kBarRows; ++y)
        for (size_t c = 0; c < 3; ++c) at(x0 + x, y)[c] = static_cast<float>(code[c]) / 255.f;
    }
    const std::string low = small_text(map.scale.low), high = small_text(map.scale.high);
    const int low_px = small_text_width(low), high_px = small_text_width(high);
    if (low_px + high_px + kGap_px > width) return;  // too narrow for numbers
    write(low, x0);
    write(high, x0 + width - high_px);
  }
  const float* row(int y) const { return rows_.data() + static_cast<size_t>(y) * row_floats_; }

 private:
  float* at(int x, int y) { return rows_.data() + static_cast<size_t>(y) * row_floats_ + 3 * static_cast<size_t>(x); }
  void write(const std::string& text, int x0) {
    draw_small_text(text, [&](int x, int y) { std::fill_n(at(x0 + x, kGap_px + kBarRows + 4 + y), 3, .9f); });
  }

  std::vector<float> rows_;
  size_t row_floats_;
};

}  // namespace

MapScale find_map_scale(const std::string& file) {
  MapPanel panel({file, "", ColourMap::kMagma, {}});
  ScaleFinder finder;
  std::vector<float> values;
  for (int y = 0; y < panel.height(); y += kStripRows) {
    check_cancel();
    panel.means(y, std::min(y + kStripRows, panel.height()), values);
    for (const float value : values) finder.add(value);
  }
  return {finder.low(), finder.high()};
}

void draw_map(const ShownMap& map, const std::string& path) {
  MapPanel panel(map);
  ImageSpec spec = picture_spec(panel.width(), panel.height());
  spec.metadata.set("triad:map-scale", scale_text(map.scale));
  const auto writer = ImageWriter::open(path, spec);
  const size_t stride = static_cast<size_t>(panel.width()) * 3;
  std::vector<float> strip(stride * kStripRows);
  for (int y = 0; y < panel.height(); y += kStripRows) {
    check_cancel();
    const int end = std::min(y + kStripRows, panel.height());
    panel.rows(y, end, strip.data(), stride);
    writer->write_rows(y, end, strip.data(), stride);
  }
  writer->commit();
}

void draw_sheet(const PictureRequest& reference, const PictureRequest& test, const std::vector<ShownMap>& maps,
                const SheetOptions& options, const ColourConfig& colours, const std::string& path) {
  auto wanted = std::make_unique<PicturePanel>(reference, colours, options.exposure_ev);
  auto judged = std::make_unique<PicturePanel>(test, colours, options.exposure_ev);
  wanted->reduce_to(judged->width(), judged->height());
  const bool bends = !wanted->display_codes() || !judged->display_codes();
  wanted->set_bend(bends);
  judged->set_bend(bends);
  std::vector<std::unique_ptr<Panel>> panels;
  panels.push_back(std::move(wanted));
  panels.push_back(std::move(judged));
  for (const ShownMap& map : maps) panels.push_back(std::make_unique<MapPanel>(map));

  int width = -kGap_px, tallest = 0;
  for (const auto& panel : panels) {
    if (panel->width() > INT32_MAX - kGap_px - std::max(width, 0))
      throw_input("cannot write '" + path + "': the pictures side by side are too wide");
    width += panel->width() + kGap_px;
    tallest = std::max(tallest, panel->height());
  }
  const size_t stride = static_cast<size_t>(width) * 3;
  Legend legend(stride);
  ImageSpec spec = picture_spec(width, tallest + kLegendRows);
  int x0 = panels[0]->width() + panels[1]->width() + 2 * kGap_px;
  std::vector<std::string> scales;
  for (size_t m = 0; m < maps.size(); ++m) {
    legend.add(maps[m], x0, panels[m + 2]->width());
    x0 += panels[m + 2]->width() + kGap_px;
    scales.push_back(maps[m].label + " " + scale_text(maps[m].scale));
  }
  spec.metadata.set("triad:map-scale", join(scales, ", "));
  const auto writer = ImageWriter::open(path, spec);
  std::vector<float> strip(stride * kStripRows);
  for (int y = 0; y < tallest; y += kStripRows) {
    check_cancel();
    const int end = std::min(y + kStripRows, tallest);
    std::fill(strip.begin(), strip.end(), kPaper);
    size_t column = 0;
    for (const auto& panel : panels) {
      panel->rows(y, end, strip.data() + column, stride);
      column += static_cast<size_t>(panel->width() + kGap_px) * 3;
    }
    writer->write_rows(y, end, strip.data(), stride);
  }
  writer->write_rows(tallest, tallest + kLegendRows, legend.row(0), stride);
  writer->commit();
}

}  // namespace triad::app
