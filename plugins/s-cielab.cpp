// SPDX-License-Identifier: Apache-2.0
#include "colour_difference.hpp"
#include "display_parameters.hpp"

#include <memory>
#include <triad/display/s_cielab.hpp>
#include <vector>

namespace {

namespace tp = triad_plugin;
namespace cp = compared_pictures;

enum class Beyond { kMirror, kWrap };

struct Scielab {
  static constexpr tp::Info info{
      "s-cielab", "1.0", "S-CIELAB: the colour difference that an eye sees from a distance",
      "Both pictures, as linear light, are blurred in the opponent channels of Zhang and Wandell (1996) as an eye "
      "does "
      "at ppd pixels per degree, and compared by CIE 1976 (1997 in the SID Journal 5(1)). The kernels are sums of "
      "Gaussians with a sum of 1, that of luminance with its negative third one, of 4.336 degrees; CIELAB's white is "
      "that of the pictures' colour space, D65 for sRGB. On flat fields it is cie76, and fine dither that an eye "
      "cannot "
      "see scores next to nothing. Nothing is clamped.\n"
      "The widest kernel reaches across hundreds of pixels, so the whole picture is blurred at once, exactly, which "
      "takes about 60 bytes of memory a pixel (with edge=wrap 35) and not the strips of the other metrics. Of wide "
      "renders and other pixels that are not square, ppd counts pixels of a display in the vertical.\n"
      "mean is the mean over all pixels (with a mask: by its weights); the map is each pixel's difference. A picture "
      "as a panel's subpixels show it is judged by display, whose delta-e is this one."};
  double ppd;
  Beyond edge;

  static constexpr auto params() {
    return tp::list(tp::number<&Scielab::ppd>("ppd", "pixels per degree of visual angle; 40 is 96 dpi at 60 cm",
                                              {.def = 40, .min = 1, .max = 10000, .unit = "ppd"}),
                    tp::choice<&Scielab::edge, "mirror", "wrap">("edge", "what lies beyond the picture"));
  }
  static constexpr auto inputs() { return colour_difference::kInputs; }
  static constexpr auto scores() { return tp::list(colour_difference::kMeanScore); }
  using State = triad::WeightedMean;

  void plan(tp::PlanCall& call) {
    cp::require_same_size(call);
    const triad_image &test = call.in(0), &reference = call.in(1);
    for (int i = 0; i < 9; ++i)
      if (!(std::abs(test.rgb_to_xyz[i] - reference.rgb_to_xyz[i]) < 1e-4))
        throw tp::Error(
            TRIAD_E_INPUT,
            "test and reference have different primaries; bring them to one colour space first, as triad run "
            "--to SPACE -o FILE does");
    if (test.cells_x != reference.cells_x || test.cells_y != reference.cells_y)
      throw tp::Error(TRIAD_E_INPUT, "test and reference have different cells a pixel; they must be alike");
    width_ = static_cast<size_t>(test.width);
    height_ = static_cast<size_t>(test.height);
    const size_t times = edge == Beyond::kMirror ? 2 : 1;
    const double rows_per_degree = ppd * test.cells_y;
    const triad::SCielab::Shape shape{
        times * width_, times * height_, width_, height_, rows_per_degree / test.pixel_aspect, rows_per_degree};
    metric_ = display_parameters::in_library(
        [&] { return std::make_unique<triad::SCielab>(colour_difference::to_xyz(test), shape); });
    call.out.channels = 1;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
    call.plan.strip_rows = -1;
    call.work_bytes(metric_->workspace_bytes() + width_ * height_ * sizeof(double));
  }

  void strip(tp::StripCall& call, State& state) const {
    triad::SCielab::Workspace work(*metric_);
    std::vector<double> delta_e(width_ * height_);
    metric_->delta_e(
        light(call.in(0)), light(call.in(1)),
        [&](size_t y, const double* values) { std::copy_n(values, width_, &delta_e[y * width_]); }, work);
    cp::for_blocks(call, 2, [&](int x, int y, size_t count, const float* weights) {
      const double* values = &delta_e[static_cast<size_t>(y) * width_ + static_cast<size_t>(x)];
      state.add(values, weights, count);
      if (call.has_out()) cp::write_map(call, x, y, values, count);
    });
  }
  void merge(int, State& into, const State& from) const { into.merge(from); }
  void end_pass(tp::EndCall& call, const State& all) { call.scores[0] = cp::mean_of(all); }

 private:
  // A picture and, mirrored, its images on the right and below.
  triad::Light light(const tp::View<const float>& picture) const {
    return [this, picture](size_t y, double* rgb) {
      const float* row = picture.row(static_cast<int>(y < height_ ? y : 2 * height_ - 1 - y));
      for (size_t i = 0; i < 3 * width_; ++i) rgb[i] = static_cast<double>(row[i]);
      if (edge == Beyond::kWrap) return;
      for (size_t x = 0; x < width_; ++x) std::copy_n(&rgb[3 * (width_ - 1 - x)], 3, &rgb[3 * (width_ + x)]);
    };
  }

  size_t width_ = 0, height_ = 0;
  std::unique_ptr<triad::SCielab> metric_;
};

}  // namespace

TRIAD_PLUGIN("s-cielab", Scielab)
