// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "similarity.hpp"

namespace {

namespace tp = triad_plugin;
using similarity::Channels;

struct PuPsnr {
  static constexpr tp::Info info{
      "pu-psnr", "1.0", "Peak signal to noise ratio of PU21-encoded light, for high dynamic range",
      "Linear light (Rec. 709 primaries; display codes are decoded first) times white is luminance Y in nits, within "
      ".005 to 10000. PU21 (Mantiuk and Azimi, PCS 2021; banding and glare) makes of it "
      "V = max(p7 (((p1 + p2 Y^p4) / (1 + p3 Y^p4))^p5 - p6), 0), p = .353487901 .3734658629 8.277049286e-05 "
      ".9062562627 .09150303166 .9099517204 596.3148142: 36.5 at 1 nit, 256.4 at 100, 595.4 at 10000. The score is "
      "10 log10(256^2 / mean((V test - V reference)^2)), over pixels (with a mask: by its weights) and channels; the "
      "map is the absolute difference of V.\n"
      "channels=rgb, the default, encodes each colour channel, channels=luma luminance: PU21-PSNR and PU21-PSNRY of "
      "the authors' tool."};
  Channels channels;
  double white;

  static constexpr auto params() {
    return tp::list(tp::choice<&PuPsnr::channels, "rgb", "luma">("channels", "each colour channel, or luminance"),
                    tp::number<&PuPsnr::white>("white", "luminance of (1,1,1); 0: what the picture says, else 100",
                                               {.def = 0, .min = 0, .max = 1e6, .unit = "cd/m2"}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "the picture to judge", "rgb", "linear-rec709"},
                    tp::Input{"reference", "what it should be", "rgb", "linear-rec709"}, similarity::kMask);
  }
  static constexpr auto scores() {
    return tp::list(tp::Score{"pu-psnr", "peak signal to noise ratio of PU21 values, peak 256", "dB", 1,
                              TRIAD_SCORE_MAY_BE_INFINITE});
  }
  struct State {
    triad::NeumaierSum weight, square;
  };

  void plan(tp::PlanCall& call) {
    similarity::check_pictures(call, 1, "to compare anything");
    for (int i = 0; i < 2; ++i) light_[i] = similarity::PerceptualLight(call.in(i), white, channels);
    call.report("white", light_[0].white_nits);
    call.report("reference-white", light_[1].white_nits);
    call.out.channels = similarity::count_of(channels);
    call.plan.threads = TRIAD_REENTRANT;
  }

  void strip(tp::StripCall& call, State& state) const {
    const int count = similarity::count_of(channels);
    const auto values = call.scratch<double>(size_t{2} * kBlock_px * count);
    double *const test = values.data(), *const reference = test + kBlock_px * count;
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int x = call.r.x0; x < call.r.x1; x += kBlock_px) {
        const int pixels = std::min(kBlock_px, call.r.x1 - x);
        light_[0](call.in(0).at(x, y), static_cast<size_t>(pixels), test);
        light_[1](call.in(1).at(x, y), static_cast<size_t>(pixels), reference);
        const float* const weights = call.has(2) ? call.in(2).at(x, y) : nullptr;
        // Short plain sums inside compensated ones.
        double weight = 0, square = 0;
        for (int i = 0; i < pixels; ++i) {
          const double w = weights ? static_cast<double>(weights[i]) : 1;
          if (!(w > 0)) continue;
          weight += w;
          for (int c = i * count; c < (i + 1) * count; ++c) {
            const double d = test[c] - reference[c];
            square += w * d * d;
          }
        }
        state.weight.add(weight);
        state.square.add(square);
        if (!call.has_out()) continue;
        float* const to = call.out().at(x, y);
        for (int i = 0; i < pixels * count; ++i) to[i] = static_cast<float>(std::abs(test[i] - reference[i]));
      }
  }
  void merge(int, State& into, const State& from) const {
    into.weight.merge(from.weight);
    into.square.merge(from.square);
  }
  void end_pass(tp::EndCall& call, const State& state) {
    const double mean = state.square.value() / state.weight.value() / similarity::count_of(channels);
    const double mse = similarity::checked(mean, state.weight, false);
    call.scores[0] = 10 * std::log10(triad::kPu21Peak * triad::kPu21Peak / mse);
  }

 private:
  static constexpr int kBlock_px = 64;
  similarity::PerceptualLight light_[2];
};

}  // namespace

TRIAD_PLUGIN("pu-psnr", PuPsnr)
