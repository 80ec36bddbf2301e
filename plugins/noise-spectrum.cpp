// SPDX-License-Identifier: Apache-2.0
// A thin coat: the arithmetic is in triad/evaluation/noise_spectrum.hpp.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <triad/abi/triad_plugin.hpp>
#include <triad/evaluation/noise_spectrum.hpp>
#include <vector>

namespace {

namespace tp = triad_plugin;

struct NoiseSpectrumMetric {
  static constexpr tp::Info info{
      "noise-spectrum", "1.0", "How the error spreads over frequencies: white noise or blotches",
      "The power spectrum of test - reference in linear light of BT.709's primaries (of its luminance .2126 R + "
      ".7152 G "
      "+ .0722 B, or the mean of the channels' spectra), averaged over directions: two pictures of the same rmse "
      "differ "
      "in it, as an eye does not see fine noise that well. Tiles of tile x tile pixels (the whole side of a smaller "
      "picture) that overlap by half are weighted by a Hann window in x and y, and their periodograms averaged "
      "(Welch "
      "1967); the mean over the whole picture is subtracted first. The series 'spectrum' is the power per (cycle per "
      "pixel)^2 over cycles per pixel (with ppd: per degree): white noise of variance v has v at all frequencies, "
      "from "
      "0 to .71 in the corners. With a mask, a tile's window is multiplied by the weights. lag1-x and lag1-y are the "
      "correlation of the error in neighbouring pixels around its mean: 0 for white noise, near 1 for blotches, "
      "below 0 "
      "for blue noise. blotch is the share of the power at frequencies below `below`; the report blotch-white is "
      "that "
      "share of white noise. The test picture's error counts whole: noise of the reference is in it. A pixel is one "
      "of "
      "the file, in a wide render a cell."};

  enum class Of { kLuminance, kChannels };
  int tile;
  double below, ppd;
  Of of;

  static constexpr auto params() {
    return tp::list(
        tp::choice<&NoiseSpectrumMetric::of, "luminance", "channels">("of", "what the spectrum is of"),
        tp::integer<&NoiseSpectrumMetric::tile>(
            "tile", "side of the tiles: the lowest frequency told apart is 1 / tile",
            {.def = 256, .min = triad::kLeastSpectrumTile_px, .max = triad::kMostSpectrumTile_px, .unit = "px"}),
        tp::number<&NoiseSpectrumMetric::below>(
            "below",
            "frequencies of blotches are below this: cycles per pixel, or per degree "
            "where ppd is given; 0: a quarter of the highest, .125 per pixel",
            {.def = 0, .min = 0}),
        tp::number<&NoiseSpectrumMetric::ppd>("ppd", "pixels per degree; 0: frequencies are per pixel",
                                              {.def = 0, .min = 0, .unit = "ppd"}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "the picture to judge", "rgb", "linear-rec709"},
                    tp::Input{"reference", "what it should be", "rgb", "linear-rec709"},
                    tp::Input{"mask", "weights of the pixels", "mask", nullptr, TRIAD_INPUT_OPTIONAL});
  }
  static constexpr auto scores() {
    return tp::list(tp::Score{"lag1-x", "correlation of the error with that of the pixel to the right", nullptr, 0},
                    tp::Score{"lag1-y", "correlation of the error with that of the pixel below", nullptr, 0},
                    tp::Score{"blotch", "share of the error's power at low frequencies", nullptr, -1});
  }

  using State = triad::NoiseSums;

  void plan(tp::PlanCall& call) {
    const triad_image &test = call.in(0), &reference = call.in(1);
    if (test.width != reference.width || test.height != reference.height)
      throw tp::Error(TRIAD_E_INPUT, "the test picture is " + size_text(test) + ", the reference " +
                                         size_text(reference) + "; they must be alike");
    const double scale = ppd > 0 ? ppd : 1, cut = below > 0 ? below / scale : kCut;
    width_ = test.width;
    planes_ = of == Of::kLuminance ? 1 : 3;
    spectrum_.emplace(test.width, test.height, tile, planes_, cut);
    call.plan.strip_rows = spectrum_->strip_rows();
    call.plan.threads = TRIAD_REENTRANT;
    const auto rows =
        static_cast<uint64_t>(std::min(test.height, spectrum_->strip_rows() + spectrum_->tile_height()));
    call.work_bytes(spectrum_->work_bytes() +
                    rows * static_cast<uint64_t>(width_) * sizeof(double) * static_cast<uint64_t>(planes_ + 1));
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    const int last = spectrum_->last_row(out.y0, out.y1);
    for (int i = 0; i < 3; ++i) needs[i] = {0, out.y0, width_, last};
  }

  void strip(tp::StripCall& call, State& state) const {
    const int y0 = call.r.y0, y1 = spectrum_->last_row(call.r.y0, call.r.y1);
    const size_t pixels = static_cast<size_t>(y1 - y0) * static_cast<size_t>(width_);
    triad::NoiseRows rows{y0, y1, {}, nullptr};
    double* planes[3] = {};
    for (int p = 0; p < planes_; ++p)
      rows.plane[static_cast<size_t>(p)] = planes[p] = call.scratch<double>(pixels).data();
    double* weights = call.has(2) ? call.scratch<double>(pixels).data() : nullptr;
    rows.weight = weights;
    for (int y = y0; y < y1; ++y) {
      const size_t at = static_cast<size_t>(y - y0) * static_cast<size_t>(width_);
      if (weights) fill_weights(call, y, weights + at);
      fill_row(call, y, at, planes, weights);
    }
    spectrum_->add(rows, call.r.y0, call.r.y1, state);
  }

  void merge(int, State& into, const State& from) const { triad::NoiseSpectrum::merge(into, from); }

  void end_pass(tp::EndCall& call, const State& state) {
    const double weight = state.weight.value();
    if (!(weight > 0)) throw tp::Error(TRIAD_E_INPUT, "every pixel is left out by the mask or the crop");
    for (const triad::NeumaierSum& square : state.square)
      if (!std::isfinite(square.value()))
        throw tp::Error(TRIAD_E_INPUT,
                        "values that are not a number or infinite; leave them out or replace them first");
    triad::NoiseResult result = spectrum_->finish(state);
    const double scores[] = {result.lag_x, result.lag_y, result.low_share};
    std::copy(std::begin(scores), std::end(scores), call.scores.begin());
    call.report("blotch-white", result.white_share);
    call.report("variance", result.variance);
    if (ppd > 0)
      for (double& f : result.frequency) f *= ppd;
    call.series("spectrum", result.frequency, result.power);
  }

 private:
  static constexpr double kCut = .125;                            // cycles per pixel: a quarter of Nyquist's limit
  static constexpr double kLuminance[3] = {.2126, .7152, .0722};  // ITU-R BT.709

  static std::string size_text(const triad_image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height);
  }

  void fill_weights(const tp::StripCall& call, int y, double* to) const {
    const float* mask = call.in(2).at(0, y);
    const int channels = call.in(2).channels;
    for (int x = 0; x < width_; ++x) to[x] = static_cast<double>(mask[x * channels]);
  }

  // Pixels that are left out may hold anything: they count as 0.
  void fill_row(const tp::StripCall& call, int y, size_t at, double* const* planes, const double* weights) const {
    const float *test = call.in(0).at(0, y), *reference = call.in(1).at(0, y);
    for (int x = 0; x < width_; ++x, test += 3, reference += 3) {
      const auto i = at + static_cast<size_t>(x);
      double d[3] = {};
      if (!weights || weights[i] > 0)
        for (int c = 0; c < 3; ++c) d[c] = static_cast<double>(test[c]) - static_cast<double>(reference[c]);
      if (planes_ == 1)
        planes[0][i] = kLuminance[0] * d[0] + kLuminance[1] * d[1] + kLuminance[2] * d[2];
      else
        for (int c = 0; c < 3; ++c) planes[c][i] = d[c];
    }
  }

  int width_ = 0, planes_ = 1;
  std::optional<triad::NoiseSpectrum> spectrum_;
};

}  // namespace

TRIAD_PLUGIN("noise-spectrum", NoiseSpectrumMetric)
