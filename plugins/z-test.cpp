// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
#include <triad/abi/triad_plugin.hpp>

namespace {

namespace tp = triad_plugin;

struct ZTest {
  static constexpr tp::Info info{
      "z-test", "1.0", "Whether a render differs from its reference by more than its noise",
      "A test of every pixel and channel, for renders that hold their own variance in channels variance.R, G, B "
      "(triad "
      "render --aov variance): z = |test - reference| sqrt(spp / max(s^2, floor)) in linear light, s^2 the variance "
      "of "
      "one sample. Where the render has the reference as its expectation and enough samples, z is the absolute value "
      "of "
      "a standard normal number, and p = erfc(z / sqrt(2)) uniform between 0 and 1. A pixel's channel passes where p "
      "is "
      "not below the level 1 - (1 - significance)^(1/m) that Sidak's correction gives for m tests, those of weight "
      "above "
      "0: all m pass with probability 1 - significance (for independent channels; else more often). So Subr and Arvo "
      "(2007) test renderers, and Mitsuba 3 its own, with the floor of .0001 and a significance of .01. ks is the "
      "Kolmogorov-Smirnov distance of the p-values from uniform ones, in steps of 1/4096, where the variance is not "
      "below "
      "the floor: large where all pixels are a little off, which no single test finds. There, the report z-rms is 1 "
      "if the differences are as large as the variance "
      "says: near sqrt(spp) or its inverse, variance=mean|sample is the wrong one, or spp. "
      "The reference must be converged: its noise counts as the render's error. Few samples of long-tailed noise "
      "(fireflies) fail without bias, as their variance is underestimated where no such sample fell; stratified "
      "samples "
      "(sobol-owen) pass too easily, as their variance is overestimated. The map is z."};

  enum class Variance { kAuto, kMean, kSample };
  double spp, significance, floor;
  Variance variance;

  static constexpr auto params() {
    return tp::list(
        tp::number<&ZTest::spp>("spp",
                                "samples per pixel; 0: what the test picture's metadata says (triad:samples, "
                                "samplesPerPixel or spp)",
                                {.def = 0, .min = 0}),
        tp::choice<&ZTest::variance, "auto", "mean", "sample">(
            "variance",
            "what the channels hold: the variance of the mean, s^2 / spp, as Triad writes, or s^2 of one sample; "
            "auto: "
            "mean for pictures with triad:samples, else it must be said"),
        tp::number<&ZTest::significance>(
            "significance", "probability of a failing picture without bias",
            {.def = .01, .min = 0, .max = 1, .flags = TRIAD_PARAM_MIN_EXCLUDED | TRIAD_PARAM_MAX_EXCLUDED}),
        tp::number<&ZTest::floor>("floor", "a sample's variance is taken to be at least this",
                                  {.def = 1e-4, .min = 0, .flags = TRIAD_PARAM_MIN_EXCLUDED}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "the render to judge", "rgb", "linear"},
                    tp::Input{"reference", "its expectation", "rgb", "linear"},
                    tp::Input{"variance", "of the render, as it says itself", "variance.*"},
                    tp::Input{"mask", "weights of the pixels", "mask", nullptr, TRIAD_INPUT_OPTIONAL});
  }
  static constexpr auto scores() {
    return tp::list(tp::Score{"pass", "share of pixels and channels that pass", nullptr, 1},
                    tp::Score{"accepted", "1 where all pass: no difference is proved; else 0", nullptr, 1},
                    tp::Score{"min-p", "the smallest p-value", nullptr, 1},
                    tp::Score{"ks", "distance of the p-values from uniform ones", nullptr, -1});
  }

  static constexpr int kBins = 4096;
  // All bytes zero is an empty one. Weighted, but for the counts.
  struct State {
    double weight, passed, noisy_weight, square;  // the latter two where the variance is not below the floor
    double bins[kBins];
    double max_z;
    int64_t max_x, max_y, max_channel, tests, at_floor, nonfinite, negative;
  };

  void plan(tp::PlanCall& call) {
    const triad_image &test = call.in(0), &reference = call.in(1), &moments = call.in(2);
    if (test.width != reference.width || test.height != reference.height || test.channels != reference.channels)
      throw tp::Error(TRIAD_E_INPUT, "the test picture is " + size_text(test) + ", the reference " +
                                         size_text(reference) + "; they must be alike");
    if (moments.width != test.width || moments.height != test.height ||
        (moments.channels != test.channels && moments.channels != 1))
      throw tp::Error(TRIAD_E_INPUT, "the variance is " + size_text(moments) + ", the test picture " +
                                         size_text(test) + "; they must be alike, or the variance have one channel");
    for (int i = 0; i < 9; ++i)  // a variance cannot be brought to other primaries: it says nothing of covariances
      if (std::abs(test.rgb_to_xyz[i] - reference.rgb_to_xyz[i]) > 1e-3)
        throw tp::Error(TRIAD_E_INPUT,
                        "the test picture and the reference have different primaries, and a variance belongs to its "
                        "own; convert the reference first, or say --ref-from");
    channels_ = test.channels;
    moment_channels_ = moments.channels;
    read_samples(call, static_cast<double>(test.width) * test.height);
    call.out.channels = channels_ == 3 ? 3 : 1;
    call.plan.threads = TRIAD_REENTRANT;
    has_mask_ = call.has(3);
    if (has_mask_)  // how many tests there are is known after all weights were seen
      call.plan.passes = 2;
    else
      set_level(static_cast<int64_t>(test.width) * test.height * channels_);
  }

  void strip(tp::StripCall& call, State& state) const {
    const bool count_only = has_mask_ && call.pass == 0;
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      const float* mask = has_mask_ ? call.in(3).at(call.r.x0, y) : nullptr;
      const int stride = has_mask_ ? call.in(3).channels : 0;
      if (count_only) {
        for (int x = call.r.x0; x < call.r.x1; ++x, mask += stride)
          if (*mask > 0) state.tests += channels_;
      } else {
        test_row(call, y, mask, stride, state);
      }
    }
  }

  void merge(int, State& into, const State& from) const {
    into.weight += from.weight;
    into.passed += from.passed;
    into.noisy_weight += from.noisy_weight;
    into.square += from.square;
    for (int i = 0; i < kBins; ++i) into.bins[i] += from.bins[i];
    if (from.tests > 0 && (into.tests == 0 || from.max_z > into.max_z)) {
      into.max_z = from.max_z;
      into.max_x = from.max_x;
      into.max_y = from.max_y;
      into.max_channel = from.max_channel;
    }
    into.tests += from.tests;
    into.at_floor += from.at_floor;
    into.nonfinite += from.nonfinite;
    into.negative += from.negative;
  }

  void end_pass(tp::EndCall& call, const State& s) {
    if (has_mask_ && call.pass == 0) {
      if (s.tests > 0) set_level(s.tests);
      return;
    }
    if (s.nonfinite > 0)
      throw tp::Error(TRIAD_E_INPUT, std::to_string(s.nonfinite) +
                                         " values of the pictures or of the variance are not a number or infinite; "
                                         "leave them out or replace them first");
    if (s.negative > 0)
      throw tp::Error(TRIAD_E_INPUT, std::to_string(s.negative) +
                                         " values of the variance are below 0, which no variance is; the channels "
                                         "variance.* must hold s^2 or s^2 / spp");
    if (s.tests == 0) throw tp::Error(TRIAD_E_INPUT, "every pixel is left out by the mask or the crop");
    const double min_p = p_value(s.max_z);
    double ks = 0, below = 0;
    for (int i = 0; i < kBins && s.noisy_weight > 0; ++i) {
      below += s.bins[i];
      ks = std::max(ks, std::abs(below / s.noisy_weight - (i + 1.) / kBins));
    }
    const double scores[] = {s.passed / s.weight, min_p < level_ ? 0. : 1., min_p, ks};
    std::copy(std::begin(scores), std::end(scores), call.scores.begin());
    call.report("level", level_);
    call.report("tests", static_cast<double>(s.tests));
    call.report("spp", samples_);
    call.report("z-rms", s.noisy_weight > 0 ? std::sqrt(s.square / s.noisy_weight) : 0);
    call.report("max-z", s.max_z);
    call.report("max-x", static_cast<double>(s.max_x));
    call.report("max-y", static_cast<double>(s.max_y));
    call.report("max-channel", static_cast<double>(s.max_channel));
    call.report("at-floor", static_cast<double>(s.at_floor) / static_cast<double>(s.tests));
  }

 private:
  static std::string size_text(const triad_image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height) + " with " +
           std::to_string(image.channels) + (image.channels == 1 ? " channel" : " channels");
  }
  static std::string short_text(double v) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, v, std::chars_format::general, 6).ptr};
  }

  // Of both sides of the standard normal distribution.
  static double p_value(double z) { return std::erfc(z / std::numbers::sqrt2); }

  void set_level(int64_t tests) { level_ = -std::expm1(std::log1p(-significance) / static_cast<double>(tests)); }

  void read_samples(tp::PlanCall& call, double pixels) {
    std::string key;
    double told = 0;
    bool own = false;
    for (const char* name : {"triad:samples", "samplesPerPixel", "spp"}) {
      const auto text = call.get_meta(0, name);
      if (!text) continue;
      key = name;
      const char* const end = text->data() + text->size();
      const auto [rest, error] = std::from_chars(text->data(), end, told);
      if (error != std::errc{} || rest != end || !std::isfinite(told) || told <= 0) {
        told = 0;
        if (spp <= 0)
          throw tp::Error(TRIAD_E_INPUT, "the test picture's " + key + " is '" + *text +
                                             "', which is no number of samples; say spp=N");
      }
      own = key == "triad:samples";
      if (own) told /= pixels;  // of the whole picture
      break;
    }
    if (variance == Variance::kAuto && !own)
      throw tp::Error(TRIAD_E_INPUT,
                      "nothing tells whether the variance is that of a pixel's mean or of one sample; say "
                      "variance=mean or variance=sample");
    of_mean_ = variance != Variance::kSample;
    if (spp <= 0 && told <= 0)
      throw tp::Error(TRIAD_E_INPUT, "the test picture does not tell its samples per pixel; say spp=N");
    samples_ = spp > 0 ? spp : told;
    if (samples_ < 2)
      throw tp::Error(TRIAD_E_INPUT, "the test picture has " + short_text(samples_) + " samples per pixel" +
                                         (spp > 0 ? "" : " by its " + key) + ", and a variance is known from two on");
    constexpr double kAlike = .01;
    if (spp > 0 && told > 0 && std::abs(told - spp) > kAlike * spp)
      call.warn("spp=" + short_text(spp) + ", but the test picture's " + key + " tells of " + short_text(told) +
                " per pixel");
  }

  void test_row(const tp::StripCall& call, int y, const float* mask, int stride, State& s) const {
    const float *test = call.in(0).at(call.r.x0, y), *reference = call.in(1).at(call.r.x0, y);
    const float* moments = call.in(2).at(call.r.x0, y);
    float* out = call.has_out() ? call.out().at(call.r.x0, y) : nullptr;
    const int out_channels = call.has_out() ? call.out().channels : 0;
    for (int x = call.r.x0; x < call.r.x1; ++x) {
      const double weight = mask ? static_cast<double>(*mask) : 1;
      mask += stride;
      for (int c = 0; c < channels_; ++c) {
        const double d = std::abs(static_cast<double>(test[c]) - static_cast<double>(reference[c]));
        const auto told = static_cast<double>(moments[moment_channels_ == 1 ? 0 : c]);
        const double of_sample = of_mean_ ? told * samples_ : told;
        const double z = d * std::sqrt(samples_ / std::max(of_sample, floor));
        if (c < out_channels) out[c] = static_cast<float>(z);
        if (weight > 0) add(weight, z, of_sample, x, y, c, s);
      }
      test += channels_;
      reference += channels_;
      moments += moment_channels_;
      if (out) out += out_channels;
    }
  }

  void add(double weight, double z, double of_sample, int x, int y, int c, State& s) const {
    if (!std::isfinite(z) || !std::isfinite(of_sample)) {
      ++s.nonfinite;
      return;
    }
    const double p = p_value(z);
    s.weight += weight;
    if (p >= level_) s.passed += weight;
    if (of_sample >= floor) {
      s.noisy_weight += weight;
      s.square += weight * z * z;
      s.bins[std::min(kBins - 1, static_cast<int>(p * kBins))] += weight;
    }
    if (s.tests == 0 || z > s.max_z) {
      s.max_z = z;
      s.max_x = x;
      s.max_y = y;
      s.max_channel = c;
    }
    ++s.tests;
    s.at_floor += of_sample < floor;
    s.negative += of_sample < 0;
  }

  int channels_ = 3, moment_channels_ = 3;
  bool of_mean_ = true, has_mask_ = false;
  double samples_ = 0, level_ = 0;
};

}  // namespace

TRIAD_PLUGIN("z-test", ZTest)
