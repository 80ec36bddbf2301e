// SPDX-License-Identifier: Apache-2.0
#include <triad/abi/triad_plugin.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <triad/base/error.hpp>
#include <triad/evaluation/flip.hpp>
#include <triad/numeric/sum.hpp>
#include <vector>

namespace {

namespace tp = triad_plugin;
using triad::FloatRank;

enum class Mode { kAuto, kLdr, kHdr };
enum class Map { kError, kExposure };

// Calls the library and passes its errors on as the plugin's.
template <class F>
auto in_library(F&& body) {
  try {
    return body();
  } catch (const triad::Error& error) {
    if (error.kind() == triad::ErrorKind::kUsage) throw tp::Error(TRIAD_E_PARAM, error.what());
    throw;
  }
}

struct FlipMetric {
  static constexpr tp::Info info{
      "flip", "1.0", "FLIP: the difference that is seen on flipping between the pictures",
      "Andersson et al., FLIP: A Difference Evaluator for Alternating Images, HPG 2020, and Visualizing Errors in "
      "Rendered High Dynamic Range Images, Eurographics 2021. An error in [0, 1] for each pixel, as somebody sees it "
      "who "
      "flips between both pictures at `ppd` pixels per degree: pictures are filtered by the eye's contrast "
      "sensitivity "
      "(the pictures go on as their border), their colours compared in CIELAB after Hunt's adjustment by the HyAB "
      "distance to the power of .7, stretched to .95 at .4 of the largest and compressed above, then raised to 1 - "
      "the "
      "root of the difference of edges and points. Black against white is .967388, green against blue 1.\n"
      "mode=ldr takes pictures as a display shows them, cut to [0, 1]; mode=hdr shows light of any range at `count` "
      "exposures, evenly from `start` to `stop` stops, each through the tone mapper, and takes each pixel's largest "
      "error. start=auto is the exposure at which the reference's largest luminance is shown as .85, stop=auto that "
      "at "
      "which its median luminance is; pixels that the mask leaves out do not count. Such exposures change with the "
      "picture: give start and stop where several comparisons are to be compared. The map of map=exposure is, for "
      "each "
      "pixel, the exposure in stops at which its error was largest, start where there was none.\n"
      "mean is the mean of the errors, by the mask's weights if there is a mask. The numbers that were used are "
      "reported as hdr (0 or 1), start-exposure, stop-exposure and count."};
  double ppd;
  std::string start, stop;
  int count;
  Mode mode;
  triad::FlipToneMapper tone_mapper;
  Map map;

  static constexpr auto params() {
    return tp::list(
        tp::choice<&FlipMetric::mode, "auto", "ldr", "hdr">(
            "mode", "auto is ldr where both pictures are stored as display codes (PNG, JPEG), else hdr"),
        tp::number<&FlipMetric::ppd>("ppd",
                                     "pixels per degree: distance * pixels / width * pi / 180; the default is "
                                     "3840 pixels on .7 m seen from .7 m",
                                     {.def = 67.020645,
                                      .min = triad::FlipFilters::kLeast_ppd,
                                      .max = triad::FlipFilters::kMost_ppd,
                                      .unit = "ppd"}),
        tp::text<&FlipMetric::start>("start", "hdr: first exposure in stops, or auto", {.def = "auto"}),
        tp::text<&FlipMetric::stop>("stop", "hdr: last exposure in stops, or auto", {.def = "auto"}),
        tp::integer<&FlipMetric::count>("count", "hdr: exposures; 0 is one a stop, at least two",
                                        {.def = 0, .min = 0, .max = 1000}),
        tp::choice<&FlipMetric::tone_mapper, "aces", "reinhard", "hable">(
            "tonemapper", "hdr: what maps exposed light to what is shown"),
        tp::choice<&FlipMetric::map, "error", "exposure">("map", "what the map holds"));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "the picture to judge", "rgb", "display-or-linear"},
                    tp::Input{"reference", "what it should be", "rgb", "display-or-linear"},
                    tp::Input{"mask", "weights of the pixels", "mask", nullptr, TRIAD_INPUT_OPTIONAL});
  }
  static constexpr auto scores() { return tp::list(tp::Score{"mean", "mean of the errors", nullptr, -1}); }

  // In passes that look at luminance 2^16 counts follow in the same memory.
  struct State {
    triad::NeumaierSum error, weight;
    uint64_t pixels;
    float largest;
  };

  void create(tp::Call&) {
    start_ = stops("start", start);
    stop_ = stops("stop", stop);
    if (start_ && stop_)
      exposures_ = in_library([&] { return triad::flip_exposures(tone_mapper, start_, stop_, count, 1, 1); });
  }

  void plan(tp::PlanCall& call) {
    const triad_image &test = call.in(0), &reference = call.in(1);
    if (test.width != reference.width || test.height != reference.height)
      throw tp::Error(TRIAD_E_INPUT, "the test picture is " + size_text(test) + ", the reference " +
                                         size_text(reference) + "; they must be alike");
    if (test.cells_x != 1 || test.cells_y != 1 || reference.cells_x != 1 || reference.cells_y != 1)
      throw tp::Error(TRIAD_E_INPUT,
                      "a wide picture has several cells a pixel, and FLIP is of pictures as they are "
                      "seen, with one");
    const bool codes = call.display_codes(0) && call.display_codes(1);
    hdr_ = mode == Mode::kHdr || (mode == Mode::kAuto && !codes);
    viewing_.srgb_codes = codes;
    viewing_.tone_mapper = tone_mapper;
    if (map == Map::kExposure && !hdr_)
      throw tp::Error(TRIAD_E_PARAM, std::string("map=exposure is of mode=hdr only") +
                                         (mode == Mode::kAuto ? ", and both pictures are display codes" : ""));
    flip_ = in_library([&] { return std::make_unique<triad::Flip>(ppd); });
    if (hdr_ && start_ && stop_) set_exposures();
    luminance_passes_ = !hdr_ || (start_ && stop_) ? 0 : stop_ ? 1 : 2;
    call.out.channels = 1;
    if (map == Map::kExposure) call.pool({});
    call.plan.passes = 1 + luminance_passes_;
    call.plan.threads = TRIAD_REENTRANT;
    if (luminance_passes_ > 0) call.plan.state_bytes = sizeof(State) + sizeof(uint64_t) * FloatRank::kBins;
    call.work_bytes(sizeof(float) * piece_floats(kStripRows) + call.plan.state_bytes);
  }

  void need(int pass, triad_rect, tp::Needs& needs) const {
    if (pass < luminance_passes_) return;
    for (int i = 0; i < 2; ++i) needs[i] = tp::grown(needs[i], flip_->reach_px(), flip_->reach_px());
  }

  void strip(tp::StripCall& call, State& state) const {
    if (call.pass < luminance_passes_)
      count_luminances(call, state);
    else
      judge(call, state);
  }

  void merge(int pass, State& into, const State& from) const {
    into.error.merge(from.error);
    into.weight.merge(from.weight);
    into.largest = from.pixels > 0 && (into.pixels == 0 || from.largest > into.largest) ? from.largest : into.largest;
    into.pixels += from.pixels;
    if (pass < luminance_passes_)
      for (uint32_t bin = 0; bin < FloatRank::kBins; ++bin) counts(into)[bin] += counts(from)[bin];
  }

  void end_pass(tp::EndCall& call, const State& state) {
    if (call.pass < luminance_passes_) return end_luminances(call.pass, state);
    if (!(state.weight.value() > 0)) throw_left_out();
    call.scores[0] = state.error.value() / state.weight.value();
    call.report("hdr", hdr_ ? 1 : 0);
    if (map == Map::kError) call.report("map-max", 1);
    if (!hdr_) return;
    call.report("start-exposure", static_cast<double>(exposures_.start_stops));
    call.report("stop-exposure", static_cast<double>(exposures_.stop_stops));
    call.report("count", exposures_.count);
  }

 private:
  // Pieces of a strip: their work fits a processor's second cache.
  static constexpr int kPiece_px = 384;
  // For the memory plan: a host cuts metrics into strips of this height, and each of its threads works on one piece.
  static constexpr int kStripRows = 64;
  static constexpr int kBlock_px = 64;

  static std::optional<float> stops(const char* name, const std::string& text) {
    if (text == "auto") return std::nullopt;
    float value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(std::abs(value) <= 100))
      throw tp::Error(TRIAD_E_PARAM, std::string(name) + "=" + text +
                                         " is no exposure; a number of stops from -100 to "
                                         "100 is, or auto");
    return value;
  }

  static std::string size_text(const triad_image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height);
  }
  [[noreturn]] static void throw_left_out() {
    throw tp::Error(TRIAD_E_INPUT, "every pixel is left out by the mask or the crop");
  }

  static uint64_t* counts(State& state) { return reinterpret_cast<uint64_t*>(&state + 1); }
  static const uint64_t* counts(const State& state) { return reinterpret_cast<const uint64_t*>(&state + 1); }

  static float weight(const tp::StripCall& call, int x, int y) { return call.has(2) ? *call.in(2).at(x, y) : 1.f; }

  void set_exposures() {
    viewing_.exposures_stops.clear();
    for (int i = 0; i < exposures_.count; ++i) viewing_.exposures_stops.push_back(exposures_.at(i));
  }

  // The first pass counts the upper halves of the reference's luminances, the second the lower ones of the bin that
  // holds the median.
  void count_luminances(const tp::StripCall& call, State& state) const {
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int x = call.r.x0; x < call.r.x1; ++x) {
        if (!(weight(call, x, y) > 0)) continue;
        const float luminance = luminance_of(call.in(1).at(x, y));
        if (state.pixels == 0 || luminance > state.largest) state.largest = luminance;
        ++state.pixels;
        const uint32_t upper = FloatRank::upper_key(luminance);
        if (call.pass == 0)
          ++counts(state)[upper];
        else if (upper == median_.bin)
          ++counts(state)[FloatRank::lower_key(luminance)];
      }
  }
  float luminance_of(const float* rgb) const {
    if (!viewing_.srgb_codes) return triad::flip_luminance(rgb);
    const float light[] = {triad::flip_light(rgb[0]), triad::flip_light(rgb[1]), triad::flip_light(rgb[2])};
    return triad::flip_luminance(light);
  }

  void end_luminances(int pass, const State& state) {
    if (state.pixels == 0) throw_left_out();
    const auto above_zero = [](float luminance, const char* which, const char* advice) {
      if (!(luminance > 0))
        throw tp::Error(TRIAD_E_INPUT, std::string("the reference's ") + which +
                                           " luminance is not above 0, so no exposure follows from it; give " +
                                           advice + ", in stops");
    };
    if (pass == 0) {
      if (!start_) above_zero(state.largest, "largest", "start= and stop=");
      largest_ = state.largest;
      median_ = FloatRank::find({counts(state), FloatRank::kBins}, state.pixels / 2);
    }
    if (pass + 1 < luminance_passes_) return;
    float median = 1;
    if (!stop_) {
      median = FloatRank::value(median_.bin, FloatRank::find({counts(state), FloatRank::kBins}, median_.rank).bin);
      above_zero(median, "median", "start= and stop=");
    }
    try {
      exposures_ = in_library(
          [&] { return triad::flip_exposures(tone_mapper, start_, stop_, count, median, start_ ? 1 : largest_); });
    } catch (const tp::Error& error) {  // what does not go with this picture may go with the next
      throw tp::Error(TRIAD_E_INPUT, error.what());
    }
    set_exposures();
  }

  // Work, errors and exposures of a piece.
  size_t piece_floats(int rows) const {
    return flip_->work_floats(kPiece_px, rows) +
           2 * static_cast<size_t>(triad::Flip::row_floats(kPiece_px)) * static_cast<size_t>(rows);
  }

  void judge(tp::StripCall& call, State& state) const {
    const int pieces = (call.r.x1 - call.r.x0 + kPiece_px - 1) / kPiece_px;
    const auto sums = call.scratch<State>(static_cast<size_t>(pieces));
    call.parallel_for(pieces, [&](tp::Call& own, int64_t piece) {
      const int x0 = call.r.x0 + static_cast<int>(piece) * kPiece_px;
      judge_piece(call, own, {x0, call.r.y0, std::min(call.r.x1, x0 + kPiece_px), call.r.y1},
                  sums[static_cast<size_t>(piece)]);
    });
    for (const State& sum : sums) {
      state.error.merge(sum.error);
      state.weight.merge(sum.weight);
    }
  }

  void judge_piece(const tp::StripCall& call, tp::Call& own, triad_rect r, State& sum) const {
    const int width = r.x1 - r.x0, height = r.y1 - r.y0, row_floats = triad::Flip::row_floats(width);
    const size_t floats = static_cast<size_t>(row_floats) * static_cast<size_t>(height);
    const bool stops = map == Map::kExposure && call.has_out();
    const auto errors = own.scratch<float>(floats), worst = own.scratch<float>(stops ? floats : 0);
    const auto work = own.scratch<float>(flip_->work_floats(width, height));
    const auto picture = [&](int i) {
      const auto in = call.in(i);
      const int64_t step = in.height() > 1 ? in.row(in.r.y0 + 1) - in.row(in.r.y0) : in.row_floats();
      return triad::FlipPicture{in.at(r.x0, r.y0), step};
    };
    flip_->evaluate(picture(0), picture(1), width, height, viewing_, errors.data(), stops ? worst.data() : nullptr,
                    work.data());
    own.progress(1);
    sum = {};
    for (int y = 0; y < height; ++y) {
      const float* const row = errors.data() + static_cast<size_t>(y) * static_cast<size_t>(row_floats);
      for (int x = 0; x < width; x += kBlock_px)
        add_block(call, row + x, r.x0 + x, r.y0 + y, std::min(kBlock_px, width - x), sum);
      if (call.has_out())
        std::copy_n(stops ? worst.data() + (row - errors.data()) : row, width, call.out().at(r.x0, r.y0 + y));
    }
  }

  // Short plain sums inside compensated ones: 64 terms lose no more than 1e-14 of their sum.
  static void add_block(const tp::StripCall& call, const float* errors, int x0, int y, int n, State& sum) {
    double error = 0, weights = 0;
    if (call.has(2)) {
      const float* weight = call.in(2).at(x0, y);
      for (int i = 0; i < n; ++i) {
        const auto w = static_cast<double>(weight[i]);
        error += w * static_cast<double>(errors[i]);
        weights += w;
      }
    } else {
      // Four sums at a time: an addition waits for the one before.
      double parts[4] = {};
      int i = 0;
      for (; i + 4 <= n; i += 4)
        for (int p = 0; p < 4; ++p) parts[p] += static_cast<double>(errors[i + p]);
      for (; i < n; ++i) parts[0] += static_cast<double>(errors[i]);
      error = (parts[0] + parts[1]) + (parts[2] + parts[3]);
      weights = n;
    }
    sum.error.add(error);
    sum.weight.add(weights);
  }

  bool hdr_ = false;
  int luminance_passes_ = 0;
  std::optional<float> start_, stop_;
  triad::FlipExposures exposures_;
  triad::FlipViewing viewing_;
  std::unique_ptr<triad::Flip> flip_;
  FloatRank::Place median_{};
  float largest_ = 0;
};

}  // namespace

TRIAD_PLUGIN("flip", FlipMetric)
