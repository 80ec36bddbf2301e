// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <triad/evaluation/ms_ssim.hpp>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/elementary.hpp>

namespace triad {
namespace {

constexpr int kR = kSsimRadius_px;

struct Rows {
  int y0 = 0, y1 = 0;
};

// The shape of one scale of a strip.
struct Scale {
  int width = 0, height = 0;  // of the whole picture at this scale
  Rows out, held;             // the strip's own rows; those in memory, without what is mirrored
};

std::array<Scale, kMsSsimScales> scales_of(const MsSsimStrip& strip) {
  std::array<Scale, kMsSsimScales> scales;
  scales[0] = {strip.width, strip.height, {strip.y0, strip.y1}, {}};
  for (int k = 1; k < kMsSsimScales; ++k) {
    const Scale& finer = scales[k - 1];
    scales[k] = {(finer.width + 1) / 2, (finer.height + 1) / 2, {finer.out.y0 / 2, (finer.out.y1 + 1) / 2}, {}};
  }
  for (int k = kMsSsimScales - 1; k >= 0; --k) {
    Scale& s = scales[k];
    s.held = {s.out.y0 - kR, s.out.y1 + kR};
    if (k + 1 < kMsSsimScales) {
      s.held.y0 = std::min(s.held.y0, 2 * scales[k + 1].held.y0);
      s.held.y1 = std::max(s.held.y1, 2 * scales[k + 1].held.y1);
    }
    s.held = {std::max(s.held.y0, 0), std::min(s.held.y1, s.height)};
  }
  return scales;
}

// One picture at a scale, with a margin that mirrors it.
class Plane {
 public:
  Plane(const Scale& scale, int channels)
      : scale_(scale),
        channels_(channels),
        stride_((scale.width + 2 * kR) * ptrdiff_t{channels}),
        samples_(static_cast<size_t>(stride_ * (scale.held.y1 - scale.held.y0 + 2 * kR))) {}

  ptrdiff_t stride() const { return stride_; }
  // Pixel 0 of a row.
  double* row(int y) { return samples_.data() + (y - scale_.held.y0 + kR) * stride_ + kR * channels_; }

  // row_of(y): pixel 0 of a row of the next finer scale, whose size is `finer`.
  template <class RowOf>
  void average(const RowOf& row_of, const Scale& finer) {
    const int whole = finer.width / 2;
    for (int y = scale_.held.y0; y < scale_.held.y1; ++y) {
      const auto *const upper = row_of(2 * y), *const lower = row_of(std::min(2 * y + 1, finer.height - 1));
      double* const to = row(y);
      const auto mean = [&](int x, int right) {
        for (int c = 0; c < channels_; ++c) {
          const ptrdiff_t a = ptrdiff_t{2} * x * channels_ + c, b = ptrdiff_t{right} * channels_ + c;
          to[ptrdiff_t{x} * channels_ + c] = .25 * ((static_cast<double>(upper[a]) + static_cast<double>(upper[b])) +
                                                    (static_cast<double>(lower[a]) + static_cast<double>(lower[b])));
        }
      };
      for (int x = 0; x < whole; ++x) mean(x, 2 * x + 1);
      if (whole < scale_.width) mean(whole, 2 * whole);
      for (int x = 0; x < kR; ++x) {
        std::copy_n(to + x * channels_, channels_, to - (x + 1) * channels_);
        std::copy_n(to + (scale_.width - 1 - x) * channels_, channels_, to + (scale_.width + x) * channels_);
      }
    }
    const auto mirror = [&](int from, int into) {
      std::copy_n(row(from) - kR * channels_, stride_, row(into) - kR * channels_);
    };
    for (int y = 0; y < kR && scale_.held.y0 == 0; ++y) mirror(y, -1 - y);
    for (int y = 0; y < kR && scale_.held.y1 == scale_.height; ++y) mirror(scale_.height - 1 - y, scale_.height + y);
  }

 private:
  Scale scale_;
  int channels_;
  ptrdiff_t stride_;
  AlignedBuffer<double> samples_;
};

// The weights of the strip's own rows, averaged as the pictures are.
AlignedBuffer<float> coarser_weights(const float* weights, ptrdiff_t stride, const Scale& finer, const Scale& scale) {
  AlignedBuffer<float> out(static_cast<size_t>(scale.width) * (scale.out.y1 - scale.out.y0));
  float* to = out.data();
  for (int y = scale.out.y0; y < scale.out.y1; ++y)
    for (int x = 0; x < scale.width; ++x) {
      const float* const upper = weights + (2 * y - finer.out.y0) * stride;
      const float* const lower = weights + (std::min(2 * y + 1, finer.height - 1) - finer.out.y0) * stride;
      const int left = 2 * x, right = std::min(left + 1, finer.width - 1);
      *to++ = .25f * ((upper[left] + upper[right]) + (lower[left] + lower[right]));
    }
  return out;
}

// out[i] = max(values[i], 0)^weight * out[i]. As a power of 0 it gives 3e-14 and less.
void multiply_power(const double* values, ptrdiff_t count, double weight, double* scratch, double* out) {
  run_widest([&]() TRIAD_INLINE_BODY {
#pragma GCC ivdep
    for (ptrdiff_t i = 0; i < count; ++i) scratch[i] = values[i] > 0x1p-1000 ? values[i] : 0x1p-1000;
#pragma GCC ivdep
    for (ptrdiff_t i = 0; i < count; ++i) out[i] *= plain_pow(scratch[i], weight);
  });
}

// What the scales so far make of each pixel of the strip: those of a scale, channels interleaved.
class Product {
 public:
  explicit Product(int channels) : channels_(channels) {}
  // Begins the next finer scale.
  void refine(const Scale& scale) {
    coarse_ = std::move(values_);
    coarse_width_ = width_;
    width_ = scale.width;
    y0_ = scale.out.y0;
    values_ = AlignedBuffer<double>(static_cast<size_t>(width_) * channels_ * (scale.out.y1 - scale.out.y0));
  }
  void multiply(int x, int y, int pixels, const double* values, double weight) {
    double* const to = &values_[(static_cast<size_t>(y - y0_) * width_ + x) * channels_];
    for (int i = 0; i < pixels; ++i)
      for (int c = 0; c < channels_; ++c) to[i * channels_ + c] = coarse_.size() ? *above(x + i, y, c) : 1;
    double scratch[kSsimTile_px * 3];
    multiply_power(values, ptrdiff_t{pixels} * channels_, weight, scratch, to);
  }
  void write(int rows, float* map, ptrdiff_t stride) const {
    const double* from = values_.data();
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < width_; ++x, from += channels_) {
        double sum = 0;
        for (int c = 0; c < channels_; ++c) sum += from[c];
        map[y * stride + x] = static_cast<float>(sum / channels_);
      }
  }

 private:
  const double* above(int x, int y, int c) const {
    return &coarse_[(static_cast<size_t>(y / 2 - y0_ / 2) * coarse_width_ + x / 2) * channels_ + c];
  }
  int channels_, width_ = 0, coarse_width_ = 0, y0_ = 0;
  AlignedBuffer<double> values_, coarse_;
};

}  // namespace

void MsSsimTotals::merge(const MsSsimTotals& later) {
  for (size_t k = 0; k < scales.size(); ++k) scales[k].merge(later.scales[k]);
}

double MsSsimTotals::mean(int scale, int channel) const {
  const SsimTotals& totals = scales[scale];
  const auto& sums = scale + 1 == kMsSsimScales ? totals.ssim : totals.structure;
  return sums[channel].value() / totals.weight.value();
}

double MsSsimTotals::ms_ssim(int channels) const {
  double sum = 0;
  for (int c = 0; c < channels; ++c) {
    double product = 1;
    for (int k = 0; k < kMsSsimScales; ++k) product *= std::pow(std::max(mean(k, c), 0.), kMsSsimWeights[k]);
    sum += product;
  }
  return sum / channels;
}

template <class Sample>
void add_ms_ssim(const SsimSamples<Sample>& test, const SsimSamples<Sample>& reference, const MsSsimStrip& strip,
                 double data_range, MsSsimTotals& totals, float* map, ptrdiff_t map_stride) {
  const int channels = strip.channels;
  const auto scales = scales_of(strip);
  std::array<std::array<std::unique_ptr<Plane>, 2>, kMsSsimScales> planes;
  std::array<AlignedBuffer<float>, kMsSsimScales> weights;
  for (int k = 1; k < kMsSsimScales; ++k) {
    for (int i = 0; i < 2; ++i) {
      planes[k][i] = std::make_unique<Plane>(scales[k], channels);
      const SsimSamples<Sample>& given = i == 0 ? test : reference;
      if (k == 1)
        planes[k][i]->average([&](int y) { return given.first + (y - strip.y0) * given.stride; }, scales[0]);
      else
        planes[k][i]->average([&](int y) { return planes[k - 1][i]->row(y); }, scales[k - 1]);
    }
    if (!strip.weights) continue;
    weights[k] = k == 1 ? coarser_weights(strip.weights, strip.weights_stride, scales[0], scales[1])
                        : coarser_weights(weights[k - 1].data(), scales[k - 1].width, scales[k - 1], scales[k]);
  }
  Product product(channels);
  for (int k = kMsSsimScales - 1; k >= 0; --k) {
    const Scale& scale = scales[k];
    const float* const weight = k > 0 ? weights[k].data() : strip.weights;
    const ptrdiff_t weight_stride = k > 0 ? scale.width : strip.weights_stride;
    if (map) product.refine(scale);
    const SsimSink sink = [&](int x, int y, int pixels, const double* ssim, const double* structure) {
      totals.scales[k].add(x, y, pixels, scale.width, scale.height, channels,
                           strip.weights ? weight + (y - scale.out.y0) * weight_stride + x : nullptr, ssim,
                           structure);
      if (map) product.multiply(x, y, pixels, k + 1 == kMsSsimScales ? ssim : structure, kMsSsimWeights[k]);
    };
    const SsimArea area{0, scale.out.y0, scale.width, scale.out.y1, channels};
    if (k == 0) {
      local_ssim(test, reference, area, data_range, sink);
    } else {
      const auto samples = [&](int i) {
        return SsimSamples<double>{planes[k][i]->row(scale.out.y0), planes[k][i]->stride()};
      };
      local_ssim(samples(0), samples(1), area, data_range, sink);
    }
  }
  if (map) product.write(strip.y1 - strip.y0, map, map_stride);
}

template void add_ms_ssim(const SsimSamples<float>&, const SsimSamples<float>&, const MsSsimStrip&, double,
                          MsSsimTotals&, float*, ptrdiff_t);
template void add_ms_ssim(const SsimSamples<double>&, const SsimSamples<double>&, const MsSsimStrip&, double,
                          MsSsimTotals&, float*, ptrdiff_t);

uint64_t ms_ssim_work_bytes(int width, int rows, int channels) {
  uint64_t bytes = 0, wide = static_cast<uint64_t>(width), own = static_cast<uint64_t>(rows);
  for (int k = 0; k < kMsSsimScales; ++k, wide = (wide + 1) / 2, own = (own + 1) / 2) {
    // At scale k the rows that coarser scales see beyond the strip, and mirrored ones.
    const uint64_t high = own + 2 * static_cast<uint64_t>(kMsSsimReach_px >> k) + 2 * kR;
    if (k > 0)
      bytes += (wide + 2 * kR) * high * static_cast<uint64_t>(channels) * 2 * sizeof(double) + wide * own * 4;
    if (k < 2) bytes += wide * own * static_cast<uint64_t>(channels) * sizeof(double);  // the map's product
  }
  return bytes + (uint64_t{1} << 19);  // and local_ssim's own
}

}  // namespace triad
