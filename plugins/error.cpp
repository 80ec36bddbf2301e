// SPDX-License-Identifier: Apache-2.0
#include <triad/abi/triad_plugin.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

namespace {

namespace tp = triad_plugin;

// Neumaier's compensated sum (A. Neumaier, ZAMM 54 (1974) 39-51): the error does not grow with the count.
struct Sum {
  double sum, lost;
  void add(double v) {
    const double t = sum + v;
    lost += std::abs(sum) >= std::abs(v) ? (sum - t) + v : (v - t) + sum;
    sum = t;
  }
  void add(const Sum& other) {
    add(other.sum);
    add(other.lost);
  }
  double value() const { return sum + lost; }
};

struct ErrorMetric {
  static constexpr tp::Info info{
      "error", "1.1", "Bias, mean absolute and squared error, largest error and PSNR",
      "The difference test - reference, in linear light or in the space that compare --to names, of the three colour "
      "channels, averaged over all pixels (with "
      "a mask: by its weights) and channels. max is the largest absolute difference where the weight is not 0; "
      "max-x, max-y and max-channel (0 red, 1 green, 2 blue) report where it is first met. psnr is "
      "10 log10(peak^2 / mse), and peak is reported. share-above is the share of the pixels (with a mask: of their "
      "weight) of which some channel's absolute difference exceeds tolerance, 0 none to 1 all: idiff -fail and "
      "-failpercent, or the AE of ImageMagick's compare over the number of pixels. The map is the absolute "
      "difference "
      "of each channel."};
  double peak, tolerance;

  static constexpr auto params() {
    return tp::list(tp::number<&ErrorMetric::peak>("peak", "the value that counts as full signal for psnr",
                                                   {.def = 1, .min = 0, .flags = TRIAD_PARAM_MIN_EXCLUDED}),
                    tp::number<&ErrorMetric::tolerance>("tolerance", "the largest error that share-above lets pass",
                                                        {.def = 1e-6, .min = 0}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "the picture to judge", "rgb"},
                    tp::Input{"reference", "what it should be", "rgb"},
                    tp::Input{"mask", "weights of the pixels", "mask", nullptr, TRIAD_INPUT_OPTIONAL});
  }
  static constexpr auto scores() {
    return tp::list(tp::Score{"bias", "mean of test - reference", nullptr, 0},
                    tp::Score{"mae", "mean absolute error", nullptr, -1},
                    tp::Score{"mse", "mean squared error", nullptr, -1},
                    tp::Score{"rmse", "root of the mean squared error", nullptr, -1},
                    tp::Score{"max", "largest absolute error", nullptr, -1},
                    tp::Score{"psnr", "peak signal to noise ratio", "dB", 1, TRIAD_SCORE_MAY_BE_INFINITE},
                    tp::Score{"share-above", "share of the pixels with an error above tolerance", nullptr, -1});
  }

  struct State {
    Sum weight, bias, absolute, square, above;
    double max;
    int64_t max_x, max_y, max_channel, pixels, nonfinite;
  };

  void plan(tp::PlanCall& call) {
    const triad_image &test = call.in(0), &reference = call.in(1);
    if (test.width != reference.width || test.height != reference.height || test.channels != reference.channels)
      throw tp::Error(TRIAD_E_INPUT, "the test picture is " + size_text(test) + ", the reference " +
                                         size_text(reference) + "; they must be alike");
    channels_ = test.channels;
    call.out.channels = channels_ == 3 ? 3 : 1;
    call.plan.threads = TRIAD_REENTRANT;
  }

  void strip(tp::StripCall& call, State& state) const {
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      // Short plain sums inside compensated ones: 64 terms lose no more than 1e-14 of their sum.
      for (int x = call.r.x0; x < call.r.x1; x += kBlock_px)
        add_block(call, x, std::min(x + kBlock_px, call.r.x1), y, state);
      if (call.has_out()) write_map(call, y);
    }
  }

  void merge(int, State& into, const State& from) const {
    into.weight.add(from.weight);
    into.bias.add(from.bias);
    into.absolute.add(from.absolute);
    into.square.add(from.square);
    into.above.add(from.above);
    if (from.pixels > 0 && (into.pixels == 0 || from.max > into.max)) {
      into.max = from.max;
      into.max_x = from.max_x;
      into.max_y = from.max_y;
      into.max_channel = from.max_channel;
    }
    into.pixels += from.pixels;
    into.nonfinite += from.nonfinite;
  }

  void end_pass(tp::EndCall& call, const State& s) {
    if (s.nonfinite > 0)
      throw tp::Error(
          TRIAD_E_INPUT,
          std::to_string(s.nonfinite) + " values are not a number or infinite; leave them out or replace them first");
    if (s.pixels == 0) throw tp::Error(TRIAD_E_INPUT, "every pixel is left out by the mask or the crop");
    const double count = s.weight.value() * channels_, mse = s.square.value() / count;
    const double scores[] = {s.bias.value() / count,
                             s.absolute.value() / count,
                             mse,
                             std::sqrt(mse),
                             s.max,
                             10 * std::log10(peak * peak / mse),
                             s.above.value() / s.weight.value()};
    std::copy(std::begin(scores), std::end(scores), call.scores.begin());
    call.report("peak", peak);
    call.report("max-x", static_cast<double>(s.max_x));
    call.report("max-y", static_cast<double>(s.max_y));
    call.report("max-channel", static_cast<double>(s.max_channel));
  }

 private:
  static constexpr int kBlock_px = 64;

  static std::string size_text(const triad_image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height) + " with " +
           std::to_string(image.channels) + " channels";
  }

  void add_block(const tp::StripCall& call, int x0, int x1, int y, State& s) const {
    const float *test = call.in(0).at(x0, y), *reference = call.in(1).at(x0, y);
    double weights = 0, bias = 0, absolute = 0, square = 0, above = 0;
    for (int x = x0; x < x1; ++x, test += channels_, reference += channels_) {
      const double weight = call.has(2) ? static_cast<double>(*call.in(2).at(x, y)) : 1.0;
      if (!(weight > 0)) continue;
      bool exceeds = false;
      for (int c = 0; c < channels_; ++c) {
        const double d = static_cast<double>(test[c]) - static_cast<double>(reference[c]), a = std::abs(d);
        if (!std::isfinite(d)) {
          ++s.nonfinite;
          continue;
        }
        bias += weight * d;
        absolute += weight * a;
        square += weight * d * d;
        exceeds = exceeds || a > tolerance;
        if ((s.pixels == 0 && c == 0) || a > s.max) {
          s.max = a;
          s.max_x = x;
          s.max_y = y;
          s.max_channel = c;
        }
      }
      weights += weight;
      if (exceeds) above += weight;
      ++s.pixels;
    }
    s.weight.add(weights);
    s.bias.add(bias);
    s.absolute.add(absolute);
    s.square.add(square);
    s.above.add(above);
  }

  void write_map(const tp::StripCall& call, int y) const {
    const float *test = call.in(0).at(call.r.x0, y), *reference = call.in(1).at(call.r.x0, y);
    const auto out = call.out();
    float* to = out.row(y);
    for (int i = 0; i < out.width() * out.channels; ++i) to[i] = std::abs(test[i] - reference[i]);
  }

  int channels_ = 3;
};

}  // namespace

TRIAD_PLUGIN("error", ErrorMetric)
