// SPDX-License-Identifier: Apache-2.0
#include <triad/evaluation/ms_ssim.hpp>

#include "similarity.hpp"

namespace {

namespace tp = triad_plugin;
using similarity::Channels;

constexpr double kDataRange = 1;  // of display codes

struct MsSsim {
  static constexpr tp::Info info{
      "ms-ssim", "1.0", "Multi-scale structural similarity of display codes (Wang et al. 2003)",
      "Five scales, each the 2 x 2 average of the one before (an odd last row or column averaged with itself), "
      "weights "
      ".0448 .2856 .3001 .2363 .1333: the product of mean(structure)^weight at the four finer scales and "
      "mean(ssim)^weight at the coarsest. ssim = luminance * structure, structure = (2 cov + C2) / (vx + vy + C2), "
      "window and constants as in ssim. Identical pictures score 1. A mean below 0 counts as 0.\n"
      "It judges sRGB codes, not light: linear pictures are encoded first, light above white to codes above 1. The "
      "score is the mean of the red, green and blue scores, or that of channels=luma, .2126 R + .7152 G + .0722 B. "
      "At "
      "each scale pixels less than 5 from the edge are left out of the mean; a mask weights it, averaged like the "
      "pictures. The reports scale-1 (finest) to scale-5 are the scales' means. Pictures below 176 x 176 pixels have "
      "no coarsest scale. The map is the same product of each pixel's own values at the five scales."};
  Channels channels;

  static constexpr auto params() {
    return tp::list(tp::choice<&MsSsim::channels, "rgb", "luma">("channels", "each colour channel, or their luma"));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "the picture to judge", "rgb", "display"},
                    tp::Input{"reference", "what it should be", "rgb", "display"}, similarity::kMask);
  }
  static constexpr auto scores() {
    return tp::list(tp::Score{"ms-ssim", "multi-scale structural similarity", nullptr, 1});
  }
  using State = triad::MsSsimTotals;

  void plan(tp::PlanCall& call) {
    similarity::check_pictures(call, triad::kMsSsimLeast_px, "a window at the coarsest of five scales");
    const triad_image& test = call.in(0);
    width_ = test.width;
    height_ = test.height;
    call.out.channels = 1;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = TRIAD_EDGE_MIRROR;
    call.plan.strip_rows = kStripRows;
    similarity::pool_inside(call);
    const int rows = kStripRows + 2 * triad::kMsSsimReach_px;
    call.work_bytes(triad::ms_ssim_work_bytes(width_, kStripRows, similarity::count_of(channels)) +
                    (channels == Channels::kLuma ? 2 * similarity::doubles_bytes(test, rows, 1) : 0));
  }
  void need(int, triad_rect out, tp::Needs& needs) const {
    // Coarse windows end at the picture's edge, fine ones see its mirror image.
    triad_rect r = tp::grown(out, triad::kSsimRadius_px, triad::kMsSsimReach_px);
    r.y0 = std::max(r.y0, -triad::kSsimRadius_px);
    r.y1 = std::min(r.y1, height_ + triad::kSsimRadius_px);
    needs[0] = needs[1] = r;
  }

  void strip(tp::StripCall& call, State& state) const {
    const int y = call.r.y0;
    triad::MsSsimStrip strip{width_, height_, y, call.r.y1, similarity::count_of(channels), nullptr, 0};
    if (call.has(2)) {
      const auto mask = similarity::samples_of(call.in(2), 0, y);
      strip.weights = mask.first;
      strip.weights_stride = mask.stride;
    }
    float* const map = call.has_out() ? call.out().at(0, y) : nullptr;
    const ptrdiff_t map_stride = map ? call.out().row(y + 1) - call.out().row(y) : 0;
    if (channels == Channels::kRgb) {
      triad::add_ms_ssim(similarity::samples_of(call.in(0), 0, y), similarity::samples_of(call.in(1), 0, y), strip,
                         kDataRange, state, map, map_stride);
      return;
    }
    const auto luma = [](const float* rgb, size_t pixels, double* to) {
      similarity::weighted(rgb, pixels, similarity::kLuma, to);
    };
    triad::add_ms_ssim(similarity::converted(call, 0, 1, 0, y, luma), similarity::converted(call, 1, 1, 0, y, luma),
                       strip, kDataRange, state, map, map_stride);
  }
  void merge(int, State& into, const State& from) const { into.merge(from); }

  void end_pass(tp::EndCall& call, const State& state) {
    const int count = similarity::count_of(channels);
    for (int k = 0; k < triad::kMsSsimScales; ++k) {
      double mean = 0;
      for (int c = 0; c < count; ++c) mean += state.mean(k, c) / count;
      similarity::checked(mean, state.scales[static_cast<size_t>(k)].weight);
      call.report(("scale-" + std::to_string(k + 1)).c_str(), mean);
    }
    call.scores[0] = state.ms_ssim(count);
    call.report("map-max", 1);
  }

 private:
  static constexpr int kStripRows = 128;  // more than half of what they look at lies beyond them
  int width_ = 0, height_ = 0;
};

}  // namespace

TRIAD_PLUGIN("ms-ssim", MsSsim)
