// SPDX-License-Identifier: Apache-2.0
// What all functions have in common: where the picture's middle is, how long a length is, their two tones, and the
// list that they are found in.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <triad/sampling/functions.hpp>
#include <triad/sampling/named_params.hpp>

namespace triad {

// One line per function in functions.cpp's list.
struct FunctionEntry {
  const FunctionInfo& info;
  // Throws Error(kUsage) naming `option` for values that do not go together.
  std::unique_ptr<Source> (*make)(const StrategyValues& values, const View& view, const std::string& option);
};
template <class S>
FunctionEntry function_entry(const FunctionInfo& info) {
  return {info, [](const StrategyValues& values, const View& view, const std::string&) -> std::unique_ptr<Source> {
            return std::make_unique<S>(values, view);
          }};
}

// Parameters that several functions have.
inline StrategyParam angle_param(double usual_deg) {
  return {"angle", "degrees by which it is turned clockwise about the picture's middle", -360, 360, usual_deg, true};
}
inline StrategyParam shift_param(double usual_px = 0) {
  return {"shift", "pixels by which it lies right of the middle, before it is turned", -1e5, 1e5, usual_px, true};
}
// Of functions with lengths in pixels.
inline StrategyParam rows_param() {
  return {"rows", "height of the picture whose pixels lengths are given in; 0: of this one", 0, 1e5, 0};
}
// `params`, then the light of the dark and of the bright parts.
inline std::vector<StrategyParam> with_tones(std::vector<StrategyParam> params) {
  params.push_back({"low", "light of the dark parts", 0, 1e4, 0, true});
  params.push_back({"high", "light of the bright parts", 0, 1e4, 1, true});
  return params;
}

// A length of `value` pixels of a picture of values["rows"] rows, in pixels of this one.
inline double length_px(const StrategyValues& values, const std::string& name, const View& view) {
  const double rows = values.at("rows");
  return values.at(name) * (rows > 0 ? view.height_px / rows : 1);
}
// Throws Error(kUsage) if such a length is below least_px: closed forms go from one repetition to the next, and a
// pixel shall not have so many that it takes seconds.
void require_length(const FunctionInfo& info, const StrategyValues& values, const std::string& name, const View& view,
                    double least_px, const std::string& option);

// Coordinates about the picture's middle: u along the axis that points right at an angle of 0 and turns clockwise, v
// along the one that points down then.
struct Turned {
  double x, y, cosine, sine;
  Turned(const View& view, double angle_deg) : x(.5 * view.width_px), y(.5 * view.height_px) {
    // Whole right angles are exact, so that what is upright stays so.
    const double quarter = angle_deg / 90, whole = std::round(quarter);
    const double rest = (quarter - whole) * .5 * std::numbers::pi, c = std::cos(rest), s = std::sin(rest);
    switch (((static_cast<int>(whole) % 4) + 4) % 4) {
      case 0: cosine = c, sine = s; break;
      case 1: cosine = -s, sine = c; break;
      case 2: cosine = -c, sine = -s; break;
      default: cosine = s, sine = -c; break;
    }
  }
  double u(double at_x, double at_y) const { return (at_x - x) * cosine + (at_y - y) * sine; }
  double v(double at_x, double at_y) const { return (at_y - y) * cosine - (at_x - x) * sine; }
  bool upright() const { return cosine == 1; }
};

// A square wave of period 2: -1 in [1, 2), 1 in [0, 1), and its integral from 0, which swings between 0 and 1.
inline double square_wave(double t) { return std::fmod(std::floor(t), 2) == 0 ? 1 : -1; }
inline double triangle_wave(double t) { return std::abs(t - 2 * std::round(.5 * t)); }
// The filter's weight up to t, of 1.
double cumulative_at(const SeparableFilter& filter, double t_px);
// The mean of square_wave(u + t * per_px) over t, weighted by the filter.
double filtered_square_wave(double u, double per_px, const SeparableFilter& filter);

// A grey function: a tone from 0 to 1, shown as low + (high - low) * tone.
class ToneSource : public AnalyticSource {
 public:
  ToneSource(const StrategyValues& values, const View& view)
      : AnalyticSource(view), low_(values.at("low")), range_(values.at("high") - low_) {}

 protected:
  using MaybeTone = std::optional<double>;
  // The tone's mean.
  virtual double tone_in(const Box& box) const = 0;
  virtual MaybeTone gaussian_tone(Axes, Axes) const { return {}; }
  virtual MaybeTone filter_tone(Axes, const SeparableFilter&, Axes) const { return {}; }

  double light(double tone) const { return low_ + range_ * tone; }

 private:
  using Maybe = std::optional<std::array<double, 3>>;
  std::array<double, 3> grey(double tone) const { return {light(tone), light(tone), light(tone)}; }
  std::array<double, 3> mean(const Box& box) const final { return grey(tone_in(box)); }
  Maybe gaussian_mean(Axes centre, Axes sigma_px) const final {
    const MaybeTone tone = gaussian_tone(centre, sigma_px);
    return tone ? Maybe(grey(*tone)) : Maybe();
  }
  Maybe filter_mean(Axes centre, const SeparableFilter& f, Axes per_px) const final {
    const MaybeTone tone = filter_tone(centre, f, per_px);
    return tone ? Maybe(grey(*tone)) : Maybe();
  }

  double low_, range_;
};

// eval() of a source S that has `double tone(double x, double y) const`, in display pixels.
template <class S>
class TonesOf : public ToneSource {
 public:
  using ToneSource::ToneSource;
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const final {
    const S& self = static_cast<const S&>(*this);
    const double per_x = view().cells.x, per_y = view().cells.y;
    for (size_t i = 0; i < requests.size(); ++i) {
      const auto value = static_cast<float>(light(self.tone(requests[i].x / per_x, requests[i].y / per_y)));
      samples[i].rgb = {value, value, value};
      samples[i].valid = true;
    }
  }
};

const FunctionEntry& flat_function();
const FunctionEntry& ramp_function();
const FunctionEntry& half_plane_function();
const FunctionEntry& thin_line_function();
const FunctionEntry& stripes_function();
const FunctionEntry& checker_function();
const FunctionEntry& horizon_function();
const FunctionEntry& zone_plate_function();
const FunctionEntry& chirp_function();
const FunctionEntry& discs_function();
const FunctionEntry& white_on_white_function();
const FunctionEntry& small_object_function();
const FunctionEntry& speck_function();

}  // namespace triad
