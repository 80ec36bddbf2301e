// SPDX-License-Identifier: Apache-2.0
// Sources that are functions with known integrals, to judge strategies by.
#pragma once

#include <triad/image/image.hpp>
#include <triad/sampling/source.hpp>

namespace triad {

using Rgb = std::array<float, 3>;

// How large the picture is that a function is seen in, and how fine the film's pixels are.
struct View {
  int width_px = 1, height_px = 1;  // display pixels, at least 1
  Cells cells;                      // film pixels in each
};

// A function of the position on the display only, with an exact integral. Functions think in display pixels, which
// are square: x to the right, y down, from the picture's upper left corner, whatever the film's cells.
class AnalyticSource : public Source {
 public:
  // The film's sides, width_px * cells.x and height_px * cells.y, are below 2^31.
  explicit AnalyticSource(const View& view)
      : view_(view), width_(view.width_px * view.cells.x), height_(view.height_px * view.cells.y) {}
  int width() const final { return width_; }
  int height() const final { return height_; }
  SourceAbilities abilities() const override { return {.exact_integral = true, .deterministic = true}; }
  std::optional<std::array<double, 3>> integral(double x0, double y0, double x1, double y1) const final;
  std::optional<std::array<double, 3>> filtered(double x, double y, const SeparableFilter& filter) const final;

 protected:
  // A box, a filter's centre, or a Gaussian's sigmas on the display.
  struct Box {
    double x0, y0, x1, y1;
    double area() const { return (x1 - x0) * (y1 - y0); }
  };
  struct Axes {
    double x, y;
  };
  virtual std::array<double, 3> mean(const Box& box) const = 0;
  // Closed forms, where there are any: nothing means that none is known.
  virtual std::optional<std::array<double, 3>> gaussian_mean(Axes centre, Axes sigma_px) const;
  // f is the filter in film pixels, of which there are per_px in a display pixel.
  virtual std::optional<std::array<double, 3>> filter_mean(Axes centre, const SeparableFilter& f, Axes per_px) const;

  const View& view() const { return view_; }
  double width_px() const { return view_.width_px; }
  double height_px() const { return view_.height_px; }

 private:
  View view_;
  int width_, height_;
};

// eval() of a source S that has `Rgb at(double x, double y) const`, in display pixels, and befriends this.
template <class S>
class PointwiseSource : public AnalyticSource {
 public:
  using AnalyticSource::AnalyticSource;
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const final {
    const S& self = static_cast<const S&>(*this);
    const double per_x = view().cells.x, per_y = view().cells.y;
    for (size_t i = 0; i < requests.size(); ++i) {
      samples[i].rgb = self.at(requests[i].x / per_x, requests[i].y / per_y);
      samples[i].valid = true;
    }
  }
};

// origin + x * across + y * down, so that the mean is the value at the centre, for every filter that is the same both
// ways.
class RampSource final : public PointwiseSource<RampSource> {
 public:
  RampSource(int width_px, int height_px, const Rgb& origin, const Rgb& across, const Rgb& down,
             const Cells& cells = {})
      : PointwiseSource({width_px, height_px, cells}), origin_(origin), across_(across), down_(down) {}

 private:
  friend PointwiseSource;
  Rgb at(double x, double y) const;
  std::array<double, 3> value(Axes at) const;
  std::array<double, 3> mean(const Box& box) const override;
  std::optional<std::array<double, 3>> gaussian_mean(Axes centre, Axes) const override { return value(centre); }
  std::optional<std::array<double, 3>> filter_mean(Axes centre, const SeparableFilter&, Axes) const override {
    return value(centre);
  }

  Rgb origin_, across_, down_;
};

// `inside` where normal_x * x + normal_y * y < offset, `outside` elsewhere.
class HalfPlaneSource final : public PointwiseSource<HalfPlaneSource> {
 public:
  HalfPlaneSource(int width_px, int height_px, double normal_x, double normal_y, double offset, const Rgb& inside,
                  const Rgb& outside, const Cells& cells = {})
      : PointwiseSource({width_px, height_px, cells}),
        normal_x_(normal_x),
        normal_y_(normal_y),
        offset_(offset),
        inside_(inside),
        outside_(outside) {}

 private:
  friend PointwiseSource;
  Rgb at(double x, double y) const;
  std::array<double, 3> mean(const Box& box) const override;

  double normal_x_, normal_y_, offset_;
  Rgb inside_, outside_;
};

// `inside` nearer than radius_px to the centre, `outside` elsewhere.
class DiscSource final : public PointwiseSource<DiscSource> {
 public:
  DiscSource(int width_px, int height_px, double centre_x, double centre_y, double radius_px, const Rgb& inside,
             const Rgb& outside, const Cells& cells = {})
      : PointwiseSource({width_px, height_px, cells}),
        centre_x_(centre_x),
        centre_y_(centre_y),
        radius_px_(radius_px),
        inside_(inside),
        outside_(outside) {}

 private:
  friend PointwiseSource;
  Rgb at(double x, double y) const;
  std::array<double, 3> mean(const Box& box) const override;

  double centre_x_, centre_y_, radius_px_;
  Rgb inside_, outside_;
};

}  // namespace triad
