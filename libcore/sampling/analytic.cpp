// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <triad/sampling/analytic.hpp>

namespace triad {
namespace {

struct Corner {
  double x, y;
};

std::array<double, 3> mixed(const Rgb& inside, const Rgb& outside, double share) {
  std::array<double, 3> rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = share * inside[c] + (1 - share) * outside[c];
  return rgb;
}

// The integral of sqrt(1 - t^2) from 0 to t, |t| <= 1.
double half_disc(double t) { return .5 * (t * std::sqrt(std::max(0., 1 - t * t)) + std::asin(t)); }

// The area of the unit disc's part with X <= x and Y <= y.
double quarter(double x, double y) {
  if (x <= -1 || y <= -1) return 0;
  x = std::min(x, 1.);
  y = std::min(y, 1.);
  const double reach = std::sqrt(std::max(0., 1 - y * y));  // where the line Y = y leaves the disc
  // Between -reach and reach the column's height is y + sqrt(1 - X^2). Outside, the column is whole if y >= 0, and
  // empty if not.
  const double inner_begin = -reach, inner_end = std::min(x, reach);
  double area = 0;
  if (inner_end > inner_begin) area += y * (inner_end - inner_begin) + half_disc(inner_end) - half_disc(inner_begin);
  if (y >= 0) {
    area += 2 * (half_disc(std::min(x, -reach)) - half_disc(-1));
    if (x > reach) area += 2 * (half_disc(x) - half_disc(reach));
  }
  return area;
}

}  // namespace

void AnalyticSource::eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const {
  for (size_t i = 0; i < requests.size(); ++i) {
    samples[i] = Sample{};
    samples[i].rgb = at(requests[i].x, requests[i].y);
  }
}

Rgb RampSource::at(double x, double y) const {
  Rgb rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = static_cast<float>(origin_[c] + x * across_[c] + y * down_[c]);
  return rgb;
}

std::optional<std::array<double, 3>> RampSource::integral(double x0, double y0, double x1, double y1) const {
  std::array<double, 3> rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = origin_[c] + .5 * (x0 + x1) * across_[c] + .5 * (y0 + y1) * down_[c];
  return rgb;
}

Rgb HalfPlaneSource::at(double x, double y) const {
  return normal_x_ * x + normal_y_ * y < offset_ ? inside_ : outside_;
}

std::optional<std::array<double, 3>> HalfPlaneSource::integral(double x0, double y0, double x1, double y1) const {
  // Relative to the box's corner, for the digits' sake.
  const double w = x1 - x0, h = y1 - y0, offset = offset_ - normal_x_ * x0 - normal_y_ * y0;
  const Corner box[4] = {{0, 0}, {w, 0}, {w, h}, {0, h}};
  Corner kept[8];
  int n = 0;
  for (int i = 0; i < 4; ++i) {
    const Corner a = box[i], b = box[(i + 1) % 4];
    const double da = normal_x_ * a.x + normal_y_ * a.y - offset, db = normal_x_ * b.x + normal_y_ * b.y - offset;
    if (da < 0) kept[n++] = a;
    if ((da < 0) != (db < 0)) kept[n++] = {a.x + (b.x - a.x) * da / (da - db), a.y + (b.y - a.y) * da / (da - db)};
  }
  double twice_area = 0;
  for (int i = 0; i < n; ++i) {
    const Corner a = kept[i], b = kept[(i + 1) % n];
    twice_area += a.x * b.y - b.x * a.y;
  }
  return mixed(inside_, outside_, .5 * twice_area / (w * h));
}

Rgb DiscSource::at(double x, double y) const {
  const double dx = x - centre_x_, dy = y - centre_y_;
  return dx * dx + dy * dy < radius_px_ * radius_px_ ? inside_ : outside_;
}

std::optional<std::array<double, 3>> DiscSource::integral(double x0, double y0, double x1, double y1) const {
  const auto unit_x = [&](double x) { return (x - centre_x_) / radius_px_; };
  const auto unit_y = [&](double y) { return (y - centre_y_) / radius_px_; };
  const double area = quarter(unit_x(x1), unit_y(y1)) - quarter(unit_x(x0), unit_y(y1)) -
                      quarter(unit_x(x1), unit_y(y0)) + quarter(unit_x(x0), unit_y(y0));
  return mixed(inside_, outside_, area * radius_px_ * radius_px_ / ((x1 - x0) * (y1 - y0)));
}

}  // namespace triad
