// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/sampling/areas.hpp>

namespace triad {
namespace {

struct Corner {
  double x, y;
};

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

double half_plane_share(double width, double height, double normal_x, double normal_y, double offset) {
  const Corner box[4] = {{0, 0}, {width, 0}, {width, height}, {0, height}};
  Corner kept[8];
  int n = 0;
  for (int i = 0; i < 4; ++i) {
    const Corner a = box[i], b = box[(i + 1) % 4];
    const double da = normal_x * a.x + normal_y * a.y - offset, db = normal_x * b.x + normal_y * b.y - offset;
    if (da < 0) kept[n++] = a;
    if ((da < 0) != (db < 0)) kept[n++] = {a.x + (b.x - a.x) * da / (da - db), a.y + (b.y - a.y) * da / (da - db)};
  }
  double twice_area = 0;
  for (int i = 0; i < n; ++i) {
    const Corner a = kept[i], b = kept[(i + 1) % n];
    twice_area += a.x * b.y - b.x * a.y;
  }
  return .5 * twice_area / (width * height);
}

double unit_disc_area(double x0, double y0, double x1, double y1) {
  return quarter(x1, y1) - quarter(x0, y1) - quarter(x1, y0) + quarter(x0, y0);
}

}  // namespace triad
