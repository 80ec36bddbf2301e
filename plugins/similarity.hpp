// SPDX-License-Identifier: Apache-2.0
// What the metrics of structural similarity share.
#pragma once

#include <algorithm>
#include <string>
#include <triad/abi/triad_plugin.hpp>
#include <triad/evaluation/pu21.hpp>
#include <triad/evaluation/ssim.hpp>

namespace similarity {

namespace tp = triad_plugin;

enum class Channels { kRgb, kLuma };
inline int count_of(Channels channels) { return channels == Channels::kRgb ? 3 : 1; }

// Of display codes: Rec. ITU-R BT.709.
inline constexpr double kLuma[] = {.2126, .7152, .0722};

inline constexpr tp::Input kMask{"mask", "weights of the pixels", "mask", nullptr, TRIAD_INPUT_OPTIONAL};

inline std::string size_text(const triad_image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

// Both of one size, and not below least_px; `why` follows the size that is needed.
inline void check_pictures(const tp::PlanCall& call, int least_px, const std::string& why) {
  const triad_image &test = call.in(0), &reference = call.in(1);
  if (test.width != reference.width || test.height != reference.height)
    throw tp::Error(TRIAD_E_INPUT, "the test picture is " + size_text(test) + ", the reference " +
                                       size_text(reference) + "; they must be alike");
  if (test.width < least_px || test.height < least_px)
    throw tp::Error(TRIAD_E_INPUT, "the pictures are " + size_text(test) + "; at least " + std::to_string(least_px) +
                                       "x" + std::to_string(least_px) + " pixels are needed, " + why);
}

// The map is pooled where a window of the picture lies inside it.
inline void pool_inside(tp::PlanCall& call) {
  const triad_image& test = call.in(0);
  call.pool(tp::grown({0, 0, test.width, test.height}, -triad::kSsimRadius_px, -triad::kSsimRadius_px));
}

inline uint64_t doubles_bytes(const triad_image& image, int rows, int channels) {
  const auto wide = static_cast<uint64_t>(image.width) + 2 * triad::kSsimRadius_px;
  return wide * static_cast<uint64_t>(rows) * static_cast<uint64_t>(channels) * sizeof(double);
}

inline triad::SsimSamples<float> samples_of(const tp::View<const float>& view, int x, int y) {
  return {view.at(x, y), view.row(view.r.y0 + 1) - view.row(view.r.y0)};
}

// Input i in scratch memory as `channels` doubles a pixel; convert(rgb, pixels, to) makes a row. From pixel (x, y)
// on.
template <class Convert>
triad::SsimSamples<double> converted(tp::StripCall& call, int i, int channels, int x, int y, const Convert& convert) {
  const auto view = call.in(i);
  const ptrdiff_t stride = ptrdiff_t{view.width()} * channels;
  double* const first = call.scratch<double>(static_cast<size_t>(stride) * view.height()).data();
  for (int row = view.r.y0; row < view.r.y1; ++row)
    convert(view.row(row), static_cast<size_t>(view.width()), first + (row - view.r.y0) * stride);
  return {first + (y - view.r.y0) * stride + ptrdiff_t{x - view.r.x0} * channels, stride};
}

inline void weighted(const float* rgb, size_t pixels, const double* weights, double* to) {
  for (size_t i = 0; i < pixels; ++i)
    to[i] = (weights[0] * static_cast<double>(rgb[3 * i]) + weights[1] * static_cast<double>(rgb[3 * i + 1])) +
            weights[2] * static_cast<double>(rgb[3 * i + 2]);
}

// Linear light of a picture, encoded by PU21.
struct PerceptualLight {
  double white_nits = 100;
  Channels channels = Channels::kRgb;
  double luminance[3]{};  // of red, green and blue at 1, in nits

  // white: in nits of (1, 1, 1), or 0 for what the picture says, else 100.
  PerceptualLight() = default;
  PerceptualLight(const triad_image& image, double white, Channels wanted)
      : white_nits(white > 0              ? white
                   : image.white_nits > 0 ? image.white_nits
                                          : 100),
        channels(wanted) {
    for (int c = 0; c < 3; ++c) luminance[c] = image.rgb_to_xyz[3 + c] * white_nits;
  }
  void operator()(const float* rgb, size_t pixels, double* to) const {
    if (channels == Channels::kLuma)
      weighted(rgb, pixels, luminance, to);
    else
      for (size_t i = 0; i < 3 * pixels; ++i) to[i] = static_cast<double>(rgb[i]) * white_nits;
    triad::pu21(to, channels == Channels::kLuma ? pixels : 3 * pixels);
  }
};

// Local similarity of a strip into the totals, and into the map: the mean over channels.
template <class Sample>
void add_strip(tp::StripCall& call, const triad::SsimSamples<Sample>& test,
               const triad::SsimSamples<Sample>& reference, int channels, int height, double data_range,
               triad::SsimTotals& totals) {
  const triad::SsimArea area{call.r.x0, call.r.y0, call.r.x1, call.r.y1, channels};
  triad::local_ssim(test, reference, area, data_range,
                    [&](int x, int y, int pixels, const double* ssim, const double* structure) {
                      totals.add(x, y, pixels, call.r.x1, height, channels,
                                 call.has(2) ? call.in(2).at(x, y) : nullptr, ssim, structure);
                      if (!call.has_out()) return;
                      float* const to = call.out().at(x, y);
                      for (int i = 0; i < pixels; ++i) {
                        double sum = 0;
                        for (int c = 0; c < channels; ++c) sum += ssim[i * channels + c];
                        to[i] = static_cast<float>(sum / channels);
                      }
                    });
}

// border: whether pixels at the edge do not count.
inline double checked(double score, const triad::NeumaierSum& weight, bool border = true) {
  if (!(weight.value() > 0))
    throw tp::Error(TRIAD_E_INPUT, std::string("every pixel is left out by the mask or the crop") +
                                       (border ? ", or lies too near the edge" : ""));
  if (!(score - score == 0))
    throw tp::Error(TRIAD_E_INPUT, "values are not a number or infinite; leave them out or replace them first");
  return score;
}

inline double mean_ssim(const triad::SsimTotals& totals, int channels) {
  double sum = 0;
  for (int c = 0; c < channels; ++c) sum += totals.ssim[static_cast<size_t>(c)].value();
  return checked(sum / totals.weight.value() / channels, totals.weight);
}

}  // namespace similarity
