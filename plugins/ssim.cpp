// SPDX-License-Identifier: Apache-2.0
#include "similarity.hpp"

namespace {

namespace tp = triad_plugin;
using similarity::Channels;

constexpr double kDataRange = 1;  // of display codes

struct Ssim {
  static constexpr tp::Info info{
      "ssim", "1.0", "Structural similarity of display codes (Wang et al. 2004)",
      "ssim = (2 mx my + C1)(2 cov + C2) / ((mx^2 + my^2 + C1)(vx + vy + C2)), with means, variances and covariance "
      "under a Gaussian window of sigma 1.5 pixels, cut off at 11 x 11, that sums to 1; C1 = .01^2, C2 = .03^2 for "
      "a data range of 1. Identical pictures score 1.\n"
      "It judges sRGB codes, not light: linear pictures are encoded first, light above white to codes above 1. For "
      "high dynamic range, pu-ssim. Scores depend on the size: a picture seen smaller should be compared smaller.\n"
      "The score is the mean over pixels (with a mask: by its weights; a window sees its neighbours whatever their "
      "weight) and over red, green and blue, or of channels=luma, .2126 R + .7152 G + .0722 B. Pixels less than 5 "
      "from "
      "the edge, whose windows leave the picture, are left out of the mean; the map, each pixel's own ssim, mirrors "
      "the picture there. It is what scikit-image computes with gaussian_weights=True, sigma=1.5, "
      "use_sample_covariance=False, data_range=1."};
  Channels channels;

  static constexpr auto params() {
    return tp::list(tp::choice<&Ssim::channels, "rgb", "luma">("channels", "each colour channel, or their luma"));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "the picture to judge", "rgb", "display"},
                    tp::Input{"reference", "what it should be", "rgb", "display"}, similarity::kMask);
  }
  static constexpr auto scores() { return tp::list(tp::Score{"ssim", "mean structural similarity", nullptr, 1}); }
  using State = triad::SsimTotals;

  void plan(tp::PlanCall& call) {
    similarity::check_pictures(call, triad::kSsimWindow_px, "the size of its window");
    height_ = call.in(0).height;
    call.out.channels = 1;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = TRIAD_EDGE_MIRROR;
    call.plan.strip_rows = kStripRows;
    similarity::pool_inside(call);
    const int rows = kStripRows + 2 * triad::kSsimRadius_px;
    call.work_bytes(kWindowBytes +
                    (channels == Channels::kLuma ? 2 * similarity::doubles_bytes(call.in(0), rows, 1) : 0));
  }
  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = needs[1] = tp::grown(out, triad::kSsimRadius_px, triad::kSsimRadius_px);
  }

  void strip(tp::StripCall& call, State& state) const {
    const int x = call.r.x0, y = call.r.y0;
    if (channels == Channels::kRgb) {
      similarity::add_strip(call, similarity::samples_of(call.in(0), x, y), similarity::samples_of(call.in(1), x, y),
                            3, height_, kDataRange, state);
      return;
    }
    const auto luma = [](const float* rgb, size_t pixels, double* to) {
      similarity::weighted(rgb, pixels, similarity::kLuma, to);
    };
    similarity::add_strip(call, similarity::converted(call, 0, 1, x, y, luma),
                          similarity::converted(call, 1, 1, x, y, luma), 1, height_, kDataRange, state);
  }
  void merge(int, State& into, const State& from) const { into.merge(from); }
  void end_pass(tp::EndCall& call, const State& state) {
    call.scores[0] = similarity::mean_ssim(state, similarity::count_of(channels));
    call.report("map-max", 1);
  }

 private:
  static constexpr int kStripRows = 64;
  static constexpr uint64_t kWindowBytes = 1 << 19;
  int height_ = 0;
};

}  // namespace

TRIAD_PLUGIN("ssim", Ssim)
