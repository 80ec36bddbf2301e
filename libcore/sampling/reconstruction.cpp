// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/numeric/sum.hpp>
#include <triad/sampling/reconstruction.hpp>

namespace triad {
namespace {

using std::numbers::pi;

// Cells of a half axis. A multiple of the denominators of all knots over their radii (the zero of Mitchell's filter
// is 8/7 of 2), so that each knot is a border of cells.
constexpr int kCells = 2 * 3 * 7 * 64;

struct Shape {
  double radius_px;
  std::vector<double> knots_px;
};
const Shape& shape(ReconstructionKernel kernel) {
  static const std::vector<Shape> shapes{{.5, {0, .5}},          {2, {0, 2}},    {1, {0, 1}},       {1.5, {0, 1.5}},
                                         {2, {0, 1, 8. / 7, 2}}, {2, {0, 1, 2}}, {3, {0, 1, 2, 3}}, {2, {0, 2}}};
  return shapes[static_cast<size_t>(kernel)];
}

double sinc(double x) { return x == 0 ? 1 : std::sin(pi * x) / (pi * x); }

// For 0 <= x <= radius.
double kernel_value(ReconstructionKernel kernel, double x) {
  switch (kernel) {
    case ReconstructionKernel::kBox:
    case ReconstructionKernel::kBox2: return 1;
    case ReconstructionKernel::kTent: return 1 - x;
    case ReconstructionKernel::kGaussian: return std::exp(-2 * x * x) - std::exp(-4.5);
    case ReconstructionKernel::kMitchell:  // both pieces with B = C = 1/3
      return x < 1 ? (7 * x - 12) * x * x / 6 + 8. / 9 : (x - 2) * (x - 2) * (8 - 7 * x) / 18;
    case ReconstructionKernel::kLanczos2: return sinc(x) * sinc(x / 2);
    case ReconstructionKernel::kLanczos3: return sinc(x) * sinc(x / 3);
    case ReconstructionKernel::kBlackmanHarris: {
      const double angle = pi * x / 2;
      return .35875 + .48829 * std::cos(angle) + .14128 * std::cos(2 * angle) + .01168 * std::cos(3 * angle);
    }
  }
  throw_internal("a reconstruction filter that does not exist");
}

// Of g over [a, b]: Gauss and Legendre's rule with five points, exact for polynomials of degree 9.
template <class G>
double integrate(const G& g, double a, double b) {
  static const double inner = std::sqrt(5 - 2 * std::sqrt(10. / 7)) / 3;
  static const double outer = std::sqrt(5 + 2 * std::sqrt(10. / 7)) / 3;
  static const double inner_weight = (322 + 13 * std::sqrt(70.)) / 900,
                      outer_weight = (322 - 13 * std::sqrt(70.)) / 900;
  const double middle = (a + b) / 2, half = (b - a) / 2;
  return half * (128. / 225 * g(middle) + inner_weight * (g(middle - half * inner) + g(middle + half * inner)) +
                 outer_weight * (g(middle - half * outer) + g(middle + half * outer)));
}

double squared(double x) { return x * x; }

}  // namespace

const std::vector<std::string>& reconstruction_names() {
  static const std::vector<std::string> names{"box",      "box2",     "tent",     "gaussian",
                                              "mitchell", "lanczos2", "lanczos3", "blackman-harris"};
  return names;
}

ReconstructionFilter::ReconstructionFilter(ReconstructionKernel kernel, double scale)
    : kernel_(kernel), scale_(scale), radius_px_(shape(kernel).radius_px * scale), knots_px_(shape(kernel).knots_px) {
  if (!(scale > 0) || !std::isfinite(radius_px_))
    throw_internal("a reconstruction filter of scale " + format_double(scale));
  for (double& knot : knots_px_) knot *= scale;

  const double width = shape(kernel).radius_px / kCells;
  const auto f = [&](double x) { return kernel_value(kernel, x); };
  std::vector<double> masses;
  NeumaierSum integral, absolute, square;
  for (int i = 0; i < kCells; ++i) {
    const double a = i * width, b = (i + 1) * width, mass = integrate(f, a, b);
    integral.add(mass);
    absolute.add(std::abs(mass));
    square.add(integrate([&](double x) { return squared(f(x)); }, a, b));
    cells_.push_back({absolute.value() - std::abs(mass), std::abs(f(a)), std::abs(f(b))});
  }
  for (Cell& cell : cells_) cell.below /= absolute.value();
  cells_.push_back({1, 0, 0});
  cell_width_px_ = width * scale;
  integral_ = 2 * scale * integral.value();
  absolute_ = 2 * scale * absolute.value();
  square_ = 2 * scale * square.value();
  for (int part = 0, cell = 0; part < kCells; ++part) {
    while (cells_[static_cast<size_t>(cell) + 1].below <= static_cast<double>(part) / kCells) ++cell;
    guide_.push_back(cell);
  }
}

const std::string& ReconstructionFilter::name() const { return reconstruction_names()[static_cast<size_t>(kernel_)]; }

double ReconstructionFilter::value(double x_px) const {
  if (!(x_px >= -radius_px_ && x_px < radius_px_)) return 0;
  return kernel_value(kernel_, std::abs(x_px) / scale_);
}

double ReconstructionFilter::cumulative(double x_px) const {
  constexpr double kPart = .125;  // of a pixel, for a scale of 1
  const double end = std::min(std::abs(x_px), radius_px_);
  double from_centre = 0;
  for (size_t i = 0; i + 1 < knots_px_.size() && knots_px_[i] < end; ++i) {
    const double a = knots_px_[i] / scale_, b = std::min(knots_px_[i + 1], end) / scale_;
    const int parts = std::max(1, static_cast<int>(std::ceil((b - a) / kPart)));
    for (int part = 0; part < parts; ++part)
      from_centre += integrate([&](double x) { return kernel_value(kernel_, x); }, a + part * (b - a) / parts,
                               a + (part + 1) * (b - a) / parts);
  }
  const double share = from_centre * scale_ / integral_;
  return x_px < 0 ? .5 - share : .5 + share;
}

double ReconstructionFilter::autocorrelation(double lag_px) const {
  std::vector<double> borders;  // of pieces on which both factors are smooth
  for (const double knot : knots_px_)
    for (const double sign : {-1., 1.}) {
      borders.push_back(sign * knot);
      borders.push_back(sign * knot - lag_px);
    }
  std::sort(borders.begin(), borders.end());
  constexpr int kParts = 64;
  NeumaierSum sum;
  for (size_t i = 0; i + 1 < borders.size(); ++i) {
    const double width = (borders[i + 1] - borders[i]) / kParts;
    for (int part = 0; width > 0 && part < kParts; ++part)
      sum.add(integrate([&](double x) { return value(x) * value(x + lag_px); }, borders[i] + part * width,
                        borders[i] + (part + 1) * width));
  }
  return sum.value() / square_;
}

// The share of the half axis' integral in a cell's first part, t of its width.
double ReconstructionFilter::cell_share(const Cell& cell, const Cell& next, double t) const {
  const double mean = (cell.first + cell.last) / 2;
  const double shape_share = t * (cell.first + (cell.last - cell.first) * t / 2) / mean;
  return cell.below + (next.below - cell.below) * shape_share;
}

double ReconstructionFilter::share_below(double x_px) const {
  const double position = std::min(std::abs(x_px) / cell_width_px_, static_cast<double>(kCells));
  const auto i = std::min(static_cast<size_t>(position), static_cast<size_t>(kCells) - 1);
  const double half = cell_share(cells_[i], cells_[i + 1], position - static_cast<double>(i));
  return x_px < 0 ? .5 - half / 2 : .5 + half / 2;
}

double ReconstructionFilter::place(double u) const {
  const double signed_share = 2 * u - 1, share = std::abs(signed_share);
  auto i = static_cast<size_t>(guide_[std::min(static_cast<size_t>(share * kCells), guide_.size() - 1)]);
  while (i + 1 < static_cast<size_t>(kCells) && cells_[i + 1].below <= share) ++i;
  const Cell& cell = cells_[i];
  // t (first + (last - first) t / 2) = rest, solved so that nothing cancels.
  const double mean = (cell.first + cell.last) / 2, slope = cell.last - cell.first;
  const double rest = (share - cell.below) / (cells_[i + 1].below - cell.below) * mean;
  const double root = std::sqrt(std::max(0., squared(cell.first) + 2 * slope * rest));
  const double t = rest > 0 ? std::min(1., 2 * rest / (cell.first + root)) : 0;
  const double x = std::min((static_cast<double>(i) + t) * cell_width_px_, std::nextafter(radius_px_, 0.));
  return signed_share < 0 ? -x : x;
}

double ReconstructionFilter::splat_gain() const { return squared(square_ / squared(integral_)); }
double ReconstructionFilter::importance_gain() const { return squared(squared(absolute_ / integral_)); }
double ReconstructionFilter::uniform_gain() const { return squared(2 * radius_px_ * square_ / squared(integral_)); }

}  // namespace triad
