// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/areas.hpp>

namespace triad {
namespace {

std::array<double, 3> mixed(const Rgb& inside, const Rgb& outside, double share) {
  std::array<double, 3> rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = share * inside[c] + (1 - share) * outside[c];
  return rgb;
}

}  // namespace

std::optional<std::array<double, 3>> AnalyticSource::integral(double x0, double y0, double x1, double y1) const {
  const Cells& cells = view_.cells;
  return mean({x0 / cells.x, y0 / cells.y, x1 / cells.x, y1 / cells.y});
}

std::optional<std::array<double, 3>> AnalyticSource::filtered(double x, double y,
                                                              const SeparableFilter& filter) const {
  const double across = view_.cells.x, down = view_.cells.y, sigma = filter.gaussian_sigma_px;
  const Axes centre{x / across, y / down};
  if (sigma > 0) return gaussian_mean(centre, {sigma / across, sigma / down});
  return filter_mean(centre, filter, {across, down});
}

std::optional<std::array<double, 3>> AnalyticSource::gaussian_mean(Axes, Axes) const { return {}; }

std::optional<std::array<double, 3>> AnalyticSource::filter_mean(Axes, const SeparableFilter&, Axes) const {
  return {};
}

Rgb RampSource::at(double x, double y) const {
  Rgb rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = static_cast<float>(origin_[c] + x * across_[c] + y * down_[c]);
  return rgb;
}

std::array<double, 3> RampSource::mean(const Box& box) const {
  return value({.5 * (box.x0 + box.x1), .5 * (box.y0 + box.y1)});
}

std::array<double, 3> RampSource::value(Axes at) const {
  std::array<double, 3> rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = origin_[c] + at.x * across_[c] + at.y * down_[c];
  return rgb;
}

Rgb HalfPlaneSource::at(double x, double y) const {
  return normal_x_ * x + normal_y_ * y < offset_ ? inside_ : outside_;
}

std::array<double, 3> HalfPlaneSource::mean(const Box& box) const {
  // Relative to the box's corner, for the digits' sake.
  const double offset = offset_ - normal_x_ * box.x0 - normal_y_ * box.y0;
  return mixed(inside_, outside_, half_plane_share(box.x1 - box.x0, box.y1 - box.y0, normal_x_, normal_y_, offset));
}

Rgb DiscSource::at(double x, double y) const {
  const double dx = x - centre_x_, dy = y - centre_y_;
  return dx * dx + dy * dy < radius_px_ * radius_px_ ? inside_ : outside_;
}

std::array<double, 3> DiscSource::mean(const Box& box) const {
  const double r = radius_px_;
  const double area = unit_disc_area((box.x0 - centre_x_) / r, (box.y0 - centre_y_) / r, (box.x1 - centre_x_) / r,
                                     (box.y1 - centre_y_) / r);
  return mixed(inside_, outside_, area * r * r / box.area());
}

}  // namespace triad
