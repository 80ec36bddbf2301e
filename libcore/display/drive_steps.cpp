// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/display/internal/drive_steps.hpp>
#include <utility>

namespace triad::descent {
namespace {

template <class Real>
using Pixel = std::array<Real, 4>;

// The nearest point of 0 <= a_i, 0 <= w, a_i + w <= 1, where piece (if any) says which a_i must be 0: for a given w
// each colour is clamped on its own, so it is the root of an increasing, piecewise linear function of w.
template <class Real>
Pixel<Real> below_white(const Pixel<Real>& a, const Pixel<Real>& D, int piece) {
  std::array<std::pair<Real, Real>, 3> limits{};  // of w: where colour i begins to give way, and its weight
  size_t count = 0;
  for (size_t i = 0; i < 3; ++i)
    if (static_cast<int>(i) != piece) limits[count++] = {1 - a[i], D[i]};
  const auto order = [&](size_t i, size_t j) {
    if (limits[j].first < limits[i].first) std::swap(limits[i], limits[j]);
  };
  order(0, 1);
  if (count == 3) {
    order(1, 2);
    order(0, 1);
  }
  Real sum = D[3] * a[3], weight = D[3], w = a[3];
  for (size_t i = 0; i < count && w > limits[i].first; ++i) {
    sum += limits[i].second * limits[i].first;
    weight += limits[i].second;
    w = sum / weight;
  }
  w = std::clamp(w, Real{0}, Real{1});
  Pixel<Real> out{0, 0, 0, w};
  for (size_t i = 0; i < 3; ++i)
    if (static_cast<int>(i) != piece) out[i] = std::clamp(a[i], Real{0}, 1 - w);
  return out;
}

template <class Real>
Real distance2(const Pixel<Real>& a, const Pixel<Real>& b, const Pixel<Real>& D) {
  Real sum = 0;
  for (size_t i = 0; i < 4; ++i) sum += D[i] * (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

template <class Real>
int nearest_piece(const Pixel<Real>& a, const Pixel<Real>& D) {
  int best = 0;
  Real least = std::numeric_limits<Real>::infinity();
  for (int piece = 0; piece < 3; ++piece) {
    const Real d = distance2(below_white(a, D, piece), a, D);
    if (d < least) least = d, best = piece;
  }
  return best;
}

// The nearest point of the hull: below_white shifted by the multiplier of r + g + b + 2 w <= 2.
template <class Real>
Pixel<Real> in_hull(const Pixel<Real>& a, const Pixel<Real>& D) {
  const auto excess = [](const Pixel<Real>& p) { return p[0] + p[1] + p[2] + 2 * p[3] - 2; };
  const auto at = [&](Real multiplier) {
    Pixel<Real> shifted = a;
    for (size_t i = 0; i < 3; ++i) shifted[i] -= multiplier / D[i];
    shifted[3] -= 2 * multiplier / D[3];
    return below_white(shifted, D, -1);
  };
  Pixel<Real> point = below_white(a, D, -1);
  if (excess(point) <= 0) return point;
  // The excess falls with the multiplier along straight pieces: a secant that halves a stubborn end (Illinois) meets
  // the root in a few steps.
  Real low = 0, high = *std::min_element(D.begin(), D.end()), at_low = excess(point);
  point = at(high);
  Real at_high = excess(point);
  for (; at_high > 0; at_high = excess(point)) {
    low = high;
    at_low = at_high;
    high *= 2;
    point = at(high);
  }
  constexpr int kSteps = 40;
  for (int i = 0; i < kSteps && at_high < -std::numeric_limits<Real>::epsilon(); ++i) {
    const Real middle = (low * at_high - high * at_low) / (at_high - at_low);
    if (!(middle > low && middle < high)) break;
    const Pixel<Real> trial = at(middle);
    const Real value = excess(trial);
    if (value > 0) {
      low = middle;
      at_low = value;
      at_high /= 2;
    } else {
      high = middle;
      at_high = value;
      at_low /= 2;
      point = trial;
    }
  }
  return point;
}

}  // namespace

template <class Real>
DriveSteps<Real>::DriveSteps(const TileEquations& equations, double lambda) : E_(equations.emitters()) {
  for (int e = 0; e < E_; ++e) {
    const double D = equations.regulariser(e);
    D_.push_back(static_cast<Real>(D));
    penalty_.push_back(static_cast<Real>(penalty(lambda) * D));
    rho_.push_back(static_cast<Real>(penalty(lambda) * D / equations.tiles()));
    floor_.push_back(static_cast<Real>(lambda * lambda * D));
  }
  const Layout& layout = equations.layout();
  if (!layout.derives_white) {
    stages_ = {Stage::kBounds};
    return;
  }
  stages_ = {Stage::kHull, Stage::kPieces, Stage::kFixed};
  for (int y = 0; y < layout.tile_y; ++y)
    for (int x = 0; x < layout.tile_x; ++x) {
      std::array<int, 4> pixel{};
      for (size_t e = 0; e < layout.emitters.size(); ++e)
        if (layout.emitters[e].pixel_x == x && layout.emitters[e].pixel_y == y)
          pixel[static_cast<size_t>(layout.emitters[e].channel)] = static_cast<int>(e);
      pixels_.push_back(pixel);
    }
}

template <class Real>
typename DriveSteps<Real>::Pixel DriveSteps<Real>::nearest(Stage stage, const Pixel& a, const Pixel& D,
                                                           int piece) const {
  if (stage == Stage::kHull) return in_hull(a, D);
  return below_white(a, D, stage == Stage::kPieces ? nearest_piece(a, D) : piece);
}

// body(pixel index, i, emitters, D, box values, state values).
template <class Real>
template <class Body>
void DriveSteps<Real>::for_each_white(const TileRow<Real>& row, const Body& body) const {
  for (size_t p = 0; p < pixels_.size(); ++p) {
    Pixel D, box, state;
    for (size_t k = 0; k < 4; ++k) D[k] = D_[static_cast<size_t>(pixels_[p][k])];
    for (size_t i = 0; i < row.n; ++i) {
      for (size_t k = 0; k < 4; ++k) {
        const size_t at = static_cast<size_t>(pixels_[p][k]) * row.stride + i;
        box[k] = row.box[at];
        state[k] = row.state[at];
      }
      body(p, i, pixels_[p], D, box, state);
    }
  }
}

template <class Real>
void DriveSteps<Real>::advance(Stage stage, const TileRow<Real>& row) const {
  if (stage == Stage::kBounds) {
    for (size_t e = 0; e < static_cast<size_t>(E_); ++e)
      descent::advance(row.n, row.x + e * row.x_stride, row.box + e * row.stride, rho_[e], row.state + e * row.stride,
                       row.next + e * row.next_stride);
    return;
  }
  const Real step = stage == Stage::kPieces ? Real{1} : static_cast<Real>(kRelaxation);
  for_each_white(row, [&](size_t p, size_t i, const auto& emitters, const Pixel& D, const Pixel& box, Pixel s) {
    const int piece = row.pieces[p * row.pieces_stride + i];
    Pixel a;
    for (size_t k = 0; k < 4; ++k) a[k] = box[k] + s[k];
    const Pixel old = nearest(stage, a, D, piece);
    for (size_t k = 0; k < 4; ++k) {
      s[k] += step * (row.x[static_cast<size_t>(emitters[k]) * row.x_stride + i] - (old[k] - box[k]));
      a[k] = box[k] + s[k];
    }
    const Pixel z = nearest(stage, a, D, piece);
    for (size_t k = 0; k < 4; ++k) {
      const auto e = static_cast<size_t>(emitters[k]);
      row.state[e * row.stride + i] = s[k];
      row.next[e * row.next_stride + i] = rho_[e] * (2 * (z[k] - box[k]) - s[k]);
    }
  });
}

template <class Real>
Sums DriveSteps<Real>::advance_certified(Stage stage, const TileRow<Real>& row) const {
  Sums sums;
  if (stage == Stage::kBounds) {
    for (size_t e = 0; e < static_cast<size_t>(E_); ++e)
      sums.add(descent::advance_certified(row.n, row.x + e * row.x_stride, row.box + e * row.stride, penalty_[e],
                                          floor_[e], row.state + e * row.stride, row.next + e * row.next_stride));
    return sums;
  }
  const Real step = stage == Stage::kPieces ? Real{1} : static_cast<Real>(kRelaxation);
  for_each_white(row, [&](size_t p, size_t i, const auto& emitters, const Pixel& D, const Pixel& box, Pixel s) {
    const int piece = row.pieces[p * row.pieces_stride + i];
    Pixel a, x;
    std::array<double, 4> mu;
    for (size_t k = 0; k < 4; ++k) a[k] = box[k] + s[k];
    const Pixel old = nearest(stage, a, D, piece);
    for (size_t k = 0; k < 4; ++k) {
      const auto e = static_cast<size_t>(emitters[k]);
      x[k] = row.x[e * row.x_stride + i];
      mu[k] = static_cast<double>(penalty_[e] * (x[k] - (2 * (old[k] - box[k]) - s[k])));
      s[k] += step * (x[k] - (old[k] - box[k]));
      a[k] = box[k] + s[k];
    }
    const Pixel z = nearest(stage, a, D, piece);
    double shown = 0;
    for (size_t k = 0; k < 4; ++k) {
      const auto e = static_cast<size_t>(emitters[k]);
      row.state[e * row.stride + i] = s[k];
      row.next[e * row.next_stride + i] = z[k] - box[k] - x[k];
      sums.mu_z += mu[k] * static_cast<double>(z[k] - box[k]);
      shown += mu[k] * static_cast<double>(z[k]);
    }
    // The largest mu a over the hull lies in one of its corners: black, white, or up to two colours full.
    double colours = 0, smallest = HUGE_VAL;
    for (size_t k = 0; k < 3; ++k) {
      colours += std::max(0., mu[k]);
      smallest = std::min(smallest, mu[k]);
    }
    sums.slack += 2 * (std::max(colours - std::max(0., smallest), mu[3]) - shown);
  });
  return sums;
}

template <class Real>
void DriveSteps<Real>::reflect(Stage stage, const TileRow<Real>& row) const {
  project(stage, row);
  for (size_t e = 0; e < static_cast<size_t>(E_); ++e) {
    const Real* state = row.state + e * row.stride;
    Real* next = row.next + e * row.next_stride;
    for (size_t i = 0; i < row.n; ++i) next[i] = rho_[e] * (2 * next[i] - state[i]);
  }
}

template <class Real>
void DriveSteps<Real>::project(Stage stage, const TileRow<Real>& row) const {
  if (stage == Stage::kBounds) {
    for (size_t e = 0; e < static_cast<size_t>(E_); ++e)
      descent::project(row.n, row.box + e * row.stride, row.state + e * row.stride, row.next + e * row.next_stride);
    return;
  }
  for_each_white(row, [&](size_t p, size_t i, const auto& emitters, const Pixel& D, const Pixel& box, Pixel a) {
    for (size_t k = 0; k < 4; ++k) a[k] += box[k];
    const Pixel z = nearest(stage, a, D, row.pieces[p * row.pieces_stride + i]);
    for (size_t k = 0; k < 4; ++k) row.next[static_cast<size_t>(emitters[k]) * row.next_stride + i] = z[k] - box[k];
  });
}

template <class Real>
void DriveSteps<Real>::choose_pieces(const TileRow<Real>& row) const {
  for_each_white(row, [&](size_t p, size_t i, const auto&, const Pixel& D, const Pixel& box, Pixel a) {
    for (size_t k = 0; k < 4; ++k) a[k] += box[k];
    row.pieces[p * row.pieces_stride + i] = static_cast<uint8_t>(nearest_piece(a, D));
  });
}

Schedule::Schedule(const std::vector<Stage>& stages, const SolveOptions& options, const SolveResult& start,
                   double negligible)
    : stages_(stages), options_(options), result_(start), hull_(start) {
  result_.converged = start.start <= negligible;
  stage_done_ = options.iterations == 0;
}

bool Schedule::next() {
  if (result_.converged) return false;
  if (stage_done_ || iteration_ == options_.iterations) {
    if (options_.iterations == 0 || at_ + 1 == stages_.size()) return false;
    ++at_;
    iteration_ = 0;
    stage_done_ = false;
  }
  ++iteration_;
  ++result_.iterations;
  return true;
}

double Schedule::done() const {
  return (static_cast<double>(at_) + static_cast<double>(iteration_) / (options_.iterations + 1)) /
         static_cast<double>(stages_.size());
}

bool Schedule::certify(double quadratic_x, double quadratic_d, const Sums& sums, double tiles) {
  if (stage() != Stage::kHull)
    return descent::certify(result_, quadratic_x, quadratic_d, sums, tiles, options_.tolerance);
  // The hull's optimum is a bound only; a part of the tolerance is left for what lies within.
  constexpr double kShare = .25;
  descent::certify(hull_, quadratic_x, quadratic_d, sums, tiles, kShare * options_.tolerance);
  result_.bound = hull_.bound;
  stage_done_ = hull_.converged;
  return false;
}

template class DriveSteps<float>;
template class DriveSteps<double>;

}  // namespace triad::descent
