// SPDX-License-Identifier: Apache-2.0
// Sources that are functions with known integrals, to judge strategies by.
#pragma once

#include <triad/sampling/source.hpp>

namespace triad {

using Rgb = std::array<float, 3>;

// A function of the film position only: deterministic, without geometry, with an exact integral.
class AnalyticSource : public Source {
 public:
  // Sizes in pixels, at least 1.
  AnalyticSource(int width, int height) : width_(width), height_(height) {}
  int width() const final { return width_; }
  int height() const final { return height_; }
  SourceAbilities abilities() const final { return {.exact_integral = true, .deterministic = true}; }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const final;

 protected:
  virtual Rgb at(double x, double y) const = 0;

 private:
  int width_, height_;
};

// origin + x * across + y * down, so that a box's mean is the value at its centre.
class RampSource final : public AnalyticSource {
 public:
  RampSource(int width, int height, const Rgb& origin, const Rgb& across, const Rgb& down)
      : AnalyticSource(width, height), origin_(origin), across_(across), down_(down) {}
  std::optional<std::array<double, 3>> integral(double x0, double y0, double x1, double y1) const override;

 protected:
  Rgb at(double x, double y) const override;

 private:
  Rgb origin_, across_, down_;
};

// `inside` where normal_x * x + normal_y * y < offset, `outside` elsewhere.
class HalfPlaneSource final : public AnalyticSource {
 public:
  HalfPlaneSource(int width, int height, double normal_x, double normal_y, double offset, const Rgb& inside,
                  const Rgb& outside)
      : AnalyticSource(width, height),
        normal_x_(normal_x),
        normal_y_(normal_y),
        offset_(offset),
        inside_(inside),
        outside_(outside) {}
  // The area of the box, clipped to the half-plane (Sutherland and Hodgman, CACM 17(1), 1974).
  std::optional<std::array<double, 3>> integral(double x0, double y0, double x1, double y1) const override;

 protected:
  Rgb at(double x, double y) const override;

 private:
  double normal_x_, normal_y_, offset_;
  Rgb inside_, outside_;
};

// `inside` nearer than radius_px to the centre, `outside` elsewhere.
class DiscSource final : public AnalyticSource {
 public:
  DiscSource(int width, int height, double centre_x, double centre_y, double radius_px, const Rgb& inside,
             const Rgb& outside)
      : AnalyticSource(width, height),
        centre_x_(centre_x),
        centre_y_(centre_y),
        radius_px_(radius_px),
        inside_(inside),
        outside_(outside) {}
  // By the area of the disc below and left of a corner, at the box's four corners.
  std::optional<std::array<double, 3>> integral(double x0, double y0, double x1, double y1) const override;

 protected:
  Rgb at(double x, double y) const override;

 private:
  double centre_x_, centre_y_, radius_px_;
  Rgb inside_, outside_;
};

}  // namespace triad
