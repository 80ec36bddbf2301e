// SPDX-License-Identifier: Apache-2.0
#include "similarity.hpp"

namespace {

namespace tp = triad_plugin;
using similarity::Channels;

struct PuSsim {
  static constexpr tp::Info info{
      "pu-ssim", "1.0", "Structural similarity of PU21-encoded light, for high dynamic range",
      "Linear light (Rec. 709 primaries; display codes are decoded first) times white is luminance Y in nits, within "
      ".005 to 10000. PU21 (Mantiuk and Azimi, PCS 2021; banding and glare) makes of it "
      "V = max(p7 (((p1 + p2 Y^p4) / (1 + p3 Y^p4))^p5 - p6), 0), p = .353487901 .3734658629 8.277049286e-05 "
      ".9062562627 .09150303166 .9099517204 596.3148142: 36.5 at 1 nit, 256.4 at 100, 595.4 at 10000. The score is "
      "the mean structural similarity of V as in ssim, with a data range of 256, over pixels at least 5 from the "
      "edge "
      "(with a mask: by its weights); the map is each pixel's own. Identical pictures score 1.\n"
      "channels=luma, the default, encodes luminance, as the authors' tool does; rgb encodes each channel and takes "
      "the mean of the three. Their tool means over pixels at the edge as well."};
  Channels channels;
  double white;

  static constexpr auto params() {
    return tp::list(tp::choice<&PuSsim::channels, "rgb", "luma">("channels", "each colour channel, or luminance",
                                                                 {.def = "luma"}),
                    tp::number<&PuSsim::white>("white", "luminance of (1,1,1); 0: what the picture says, else 100",
                                               {.def = 0, .min = 0, .max = 1e6, .unit = "cd/m2"}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "the picture to judge", "rgb", "linear-rec709"},
                    tp::Input{"reference", "what it should be", "rgb", "linear-rec709"}, similarity::kMask);
  }
  static constexpr auto scores() {
    return tp::list(tp::Score{"pu-ssim", "mean structural similarity of PU21 values", nullptr, 1});
  }
  using State = triad::SsimTotals;

  void plan(tp::PlanCall& call) {
    similarity::check_pictures(call, triad::kSsimWindow_px, "the size of its window");
    for (int i = 0; i < 2; ++i) light_[i] = similarity::PerceptualLight(call.in(i), white, channels);
    height_ = call.in(0).height;
    call.report("white", light_[0].white_nits);
    call.report("reference-white", light_[1].white_nits);
    call.out.channels = 1;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = TRIAD_EDGE_MIRROR;
    call.plan.strip_rows = kStripRows;
    similarity::pool_inside(call);
    const int rows = kStripRows + 2 * triad::kSsimRadius_px;
    call.work_bytes(kWindowBytes + 2 * similarity::doubles_bytes(call.in(0), rows, similarity::count_of(channels)));
  }
  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = needs[1] = tp::grown(out, triad::kSsimRadius_px, triad::kSsimRadius_px);
  }

  void strip(tp::StripCall& call, State& state) const {
    const int x = call.r.x0, y = call.r.y0, count = similarity::count_of(channels);
    similarity::add_strip(call, similarity::converted(call, 0, count, x, y, light_[0]),
                          similarity::converted(call, 1, count, x, y, light_[1]), count, height_, triad::kPu21Peak,
                          state);
  }
  void merge(int, State& into, const State& from) const { into.merge(from); }
  void end_pass(tp::EndCall& call, const State& state) {
    call.scores[0] = similarity::mean_ssim(state, similarity::count_of(channels));
    call.report("map-max", 1);
  }

 private:
  static constexpr int kStripRows = 64;
  static constexpr uint64_t kWindowBytes = 1 << 19;
  similarity::PerceptualLight light_[2];
  int height_ = 0;
};

}  // namespace

TRIAD_PLUGIN("pu-ssim", PuSsim)
