// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/lattice_cells.hpp>

namespace triad {
namespace {

LatticePoint middle(LatticePoint a, LatticePoint b) { return {a.x + (b.x - a.x) / 2, a.y + (b.y - a.y) / 2}; }

// The sum over channels of the range of some colours.
class Range {
 public:
  void add(const PovColour& colour) {
    if (!colour.known()) return;
    for (int c = 0; c < 3; ++c) {
      least_[c] = any_ ? std::min(least_[c], colour.encoded[c]) : colour.encoded[c];
      most_[c] = any_ ? std::max(most_[c], colour.encoded[c]) : colour.encoded[c];
    }
    any_ = true;
  }
  float sum() const { return (most_[0] - least_[0]) + (most_[1] - least_[1]) + (most_[2] - least_[2]); }

 private:
  std::array<float, 3> least_{}, most_{};
  bool any_ = false;
};

}  // namespace

void PixelCells::begin(int pixel_x, int pixel_y) {
  const int bits = lattice_.bits(), half = lattice_.side() / 2;
  ++pixel_;
  cells_.clear();
  Cell& root = cells_.emplace_back();
  root.at = {pixel_x << bits, pixel_y << bits};
  root.side = lattice_.side();
  for (int k = 0; k < 4; ++k) root.corner[k] = lattice_.corner(pixel_x + (k & 1), pixel_y + (k >> 1));
  if (rules_.with_centre) root.centre = *find({root.at.x + half, root.at.y + half});
  depth_ = 0;
  area_ = 1;
}

const PovColour* PixelCells::find(LatticePoint point) {
  const LatticePoint origin = cells_.front().at;
  Found& found = found_[static_cast<size_t>(point.y - origin.y) * row_ + static_cast<size_t>(point.x - origin.x)];
  if (found.pixel != pixel_) found = {pixel_, lattice_.find(point)};
  return found.colour;
}

PixelCells::Edge PixelCells::edge(const Cell& cell, int number) const {
  constexpr int kEnds[4][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 3}};
  const int a = kEnds[number][0], b = kEnds[number][1];
  const auto at = [&](int k) {
    return LatticePoint{cell.at.x + (k & 1) * cell.side, cell.at.y + (k >> 1) * cell.side};
  };
  return {at(a), at(b), cell.corner[a], cell.corner[b]};
}

// Pixels' borders say so at once; there is no point in looking for samples on the many that have none.
bool PixelCells::may_have_more(const Edge& edge) const {
  const int bits = lattice_.bits(), mask = lattice_.side() - 1;
  if (edge.from.y == edge.to.y && (edge.from.y & mask) == 0)
    return lattice_.on_upper_border(edge.from.x >> bits, edge.from.y >> bits);
  if (edge.from.x == edge.to.x && (edge.from.x & mask) == 0)
    return lattice_.on_left_border(edge.from.x >> bits, edge.from.y >> bits);
  return true;
}

float PixelCells::difference(const Edge& edge) {
  if (!rules_.along_lines || !may_have_more(edge)) return pov_distance(edge.a, edge.b);
  Range range;
  range.add(edge.a);
  range.add(edge.b);
  const int step_x = edge.to.x > edge.from.x, step_y = edge.to.y > edge.from.y;
  for (LatticePoint p{edge.from.x + step_x, edge.from.y + step_y}; p != edge.to; p.x += step_x, p.y += step_y)
    if (const PovColour* found = find(p)) range.add(*found);
  return range.sum();
}

float PixelCells::difference(const Cell& cell) {
  float most = std::max(pov_distance(cell.corner[0], cell.corner[3]), pov_distance(cell.corner[1], cell.corner[2]));
  for (int k = 0; k < 4; ++k) most = std::max(most, difference(edge(cell, k)));
  if (cell.centre.known())
    for (const PovColour& corner : cell.corner) most = std::max(most, pov_distance(corner, cell.centre));
  return most;
}

bool PixelCells::find_active(size_t first) {
  for (size_t i = first; i < cells_.size(); ++i) cells_[i].distance = difference(cells_[i]);
  for (size_t count = cells_.size() - first;;) {
    size_t still = 0;
    for (size_t i = first; i < cells_.size(); ++i) still += active(cells_[i]);
    if (still == 0) return false;
    if (!rules_.by_area || still == count) return true;
    // The cells of a level are 1 / (4^level) of a pixel each.
    const double side = static_cast<double>(cells_.back().side) / lattice_.side();
    area_ = static_cast<double>(still) * side * side;
    count = still;
  }
}

bool PixelCells::divides(int pixel_x, int pixel_y) {
  begin(pixel_x, pixel_y);
  return rules_.depth > 0 && find_active(0);
}

bool PixelCells::look_at_centre(Cell& cell, std::vector<LatticePoint>& wanted) {
  const LatticePoint at{cell.at.x + cell.side / 2, cell.at.y + cell.side / 2};
  const PovColour* found = find(at);
  if (found)
    cell.centre = *found;
  else
    wanted.push_back(at);
  return found != nullptr;
}

void PixelCells::want_midpoints(const Cell& cell, std::vector<LatticePoint>& wanted) {
  const auto differs = [&](float distance) { return distance * area_ >= rules_.threshold; };
  for (int k = 0; k < 4; ++k) {
    const Edge e = edge(cell, k);
    const LatticePoint at = middle(e.from, e.to);
    if (find(at)) continue;
    if (!rules_.along_lines || differs(pov_distance(e.a, cell.centre)) || differs(pov_distance(e.b, cell.centre)) ||
        differs(difference(e)))
      wanted.push_back(at);
  }
}

PovColour PixelCells::midpoint(const Edge& edge) {
  if (const PovColour* found = find(middle(edge.from, edge.to))) return *found;
  if (!edge.a.known()) return edge.b;
  if (!edge.b.known()) return edge.a;
  std::array<float, 3> linear;
  for (int c = 0; c < 3; ++c) linear[c] = .5f * (edge.a.linear[c] + edge.b.linear[c]);
  return lattice_.encode(linear);
}

void PixelCells::add_children(size_t parent) {
  const Cell cell = cells_[parent];
  const PovColour upper = midpoint(edge(cell, 0)), lower = midpoint(edge(cell, 1)), left = midpoint(edge(cell, 2)),
                  right = midpoint(edge(cell, 3));
  // The nine points, row by row.
  const PovColour* const points[9] = {&cell.corner[0], &upper,          &cell.corner[1], &left,          &cell.centre,
                                      &right,          &cell.corner[2], &lower,          &cell.corner[3]};
  cells_[parent].children = static_cast<int>(cells_.size());
  for (int k = 0; k < 4; ++k) {
    Cell& child = cells_.emplace_back();
    child.side = cell.side / 2;
    child.at = {cell.at.x + (k & 1) * child.side, cell.at.y + (k >> 1) * child.side};
    for (int j = 0; j < 4; ++j) child.corner[j] = *points[(k & 1) + (j & 1) + 3 * ((k >> 1) + (j >> 1))];
  }
}

bool PixelCells::divide(int pixel_x, int pixel_y, std::vector<LatticePoint>& wanted) {
  begin(pixel_x, pixel_y);
  const size_t wanted_before = wanted.size();
  for (size_t first = 0, past = 1; depth_ < rules_.depth && find_active(first); ++depth_) {
    for (size_t i = first; i < past; ++i)
      if (active(cells_[i]) && (look_at_centre(cells_[i], wanted) || !rules_.along_lines))
        want_midpoints(cells_[i], wanted);
    if (wanted.size() > wanted_before) return false;
    for (size_t i = first; i < past; ++i)
      if (active(cells_[i])) add_children(i);
    first = past;
    past = cells_.size();
  }
  return true;
}

// Sums in an order that mirrored pictures share.
PixelCells::Mean PixelCells::mean(const Cell& cell) const {
  std::array<Mean, 4> parts;
  Mean mean;
  if (cell.children >= 0) {
    for (size_t k = 0; k < 4; ++k) parts[k] = this->mean(cells_[static_cast<size_t>(cell.children) + k]);
  } else {
    for (size_t k = 0; k < 4; ++k)
      if (cell.corner[k].known()) {
        parts[k].weight = 1;
        for (int c = 0; c < 3; ++c) parts[k].sum[c] = cell.corner[k].linear[c];
      }
  }
  mean.weight = (parts[0].weight + parts[3].weight) + (parts[1].weight + parts[2].weight);
  if (mean.weight == 0) return mean;
  for (int c = 0; c < 3; ++c) mean.sum[c] = (parts[0].sum[c] + parts[3].sum[c]) + (parts[1].sum[c] + parts[2].sum[c]);
  // A leaf stands for its area as soon as one corner is known.
  const double scale = cell.children >= 0 ? .25 : 1 / mean.weight;
  mean.weight *= scale;
  for (double& each : mean.sum) each *= scale;
  return mean;
}

std::array<double, 3> PixelCells::colour() {
  const Cell& root = cells_.front();
  Mean all = mean(root);
  if (rules_.with_centre && root.children < 0) {
    // As if divided, with the middles of all edges the means of their ends: 3/16 of each corner, 1/4 of the centre.
    int corners = 0;
    for (const PovColour& corner : root.corner) corners += corner.known();
    const double of_corners = 3. / 16 * corners, of_centre = root.centre.known() ? .25 : 0;
    all.weight = of_corners + of_centre;
    for (int c = 0; c < 3; ++c)
      all.sum[c] = of_corners * all.sum[c] + (root.centre.known() ? .25 * root.centre.linear[c] : 0);
  }
  if (all.weight == 0) return {};
  return {all.sum[0] / all.weight, all.sum[1] / all.weight, all.sum[2] / all.weight};
}

int PixelCells::points() {
  points_.clear();
  for (const Cell& cell : cells_)
    for (int k = 0; k < 4; ++k) {
      const LatticePoint at{cell.at.x + (k & 1) * cell.side, cell.at.y + (k >> 1) * cell.side};
      if (find(at)) points_.push_back(at);
    }
  const Cell& root = cells_.front();
  if (rules_.with_centre) points_.push_back({root.at.x + root.side / 2, root.at.y + root.side / 2});
  std::sort(points_.begin(), points_.end(),
            [](LatticePoint a, LatticePoint b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
  return static_cast<int>(std::unique(points_.begin(), points_.end()) - points_.begin());
}

}  // namespace triad
