// SPDX-License-Identifier: Apache-2.0
// Reconstruction filters: how samples of a picture become a pixel, as f(x) f(y) with x and y the distances between
// the sample and the pixel's centre. Samplers, splatting and resampling all take them from here.
//
// Noise gains are the variance of a pixel over that of the mean of spp independent samples, for light that is white
// noise; the product of both axes.
#pragma once

#include <string>
#include <vector>

namespace triad {

enum class ReconstructionKernel {
  kBox,             // 1 for |x| < 1/2
  kBox2,            // 1 for |x| < 2
  kTent,            // 1 - |x|
  kGaussian,        // exp(-2 x^2) - exp(-2 1.5^2): sigma 1/2, cut at 1.5, where it is made to end at 0
  kMitchell,        // Mitchell, Netravali: Reconstruction Filters in Computer Graphics (SIGGRAPH 1988), B = C = 1/3
  kLanczos2,        // sinc(x) sinc(x / 2) for |x| < 2, with sinc(x) = sin(pi x) / (pi x)
  kLanczos3,        // sinc(x) sinc(x / 3) for |x| < 3
  kBlackmanHarris,  // the window of four terms (Harris, Proc. IEEE 66(1), 1978, table 1, 92 dB), 4 pixels wide
};

// box, box2, tent, gaussian, mitchell, lanczos2, lanczos3, blackman-harris: in the order of the enumeration.
const std::vector<std::string>& reconstruction_names();

// One of them, with distances divided by a scale. Immutable; any number of threads may use it.
class ReconstructionFilter {
 public:
  // scale: above 0 and finite, else an internal error is thrown.
  explicit ReconstructionFilter(ReconstructionKernel kernel, double scale = 1);

  const std::string& name() const;
  double scale() const { return scale_; }
  double radius_px() const { return radius_px_; }
  // Whether it has negative values.
  bool is_signed() const { return absolute_ != integral_; }
  // Where, for x >= 0, it is not smooth or changes its sign: from 0 to the radius, both included, ascending.
  const std::vector<double>& knots_px() const { return knots_px_; }

  // f(x): at 0 it is 1 (Mitchell 8/9, the gaussian 1 - exp(-4.5)). 0 for x outside [-radius, radius).
  double value(double x_px) const;

  // Over the real line, along one axis: of f, |f| and f^2, to about 1e-15.
  double integral() const { return integral_; }
  double absolute_integral() const { return absolute_; }
  double square_integral() const { return square_; }
  // The integral of f up to x over that of all of f, to about 1e-14: 0 up to -radius, 1 from the radius on.
  double cumulative(double x_px) const;
  // The integral of f(x) f(x + lag) divided by that of f^2: the correlation of two splatted pixels' noise.
  double autocorrelation(double lag_px) const;

  // The share of the integral of |f| that lies below x, and its inverse for u in [0, 1): where |f| is drawn to lie by
  // a uniform number. Both are those of a function that is linear between 2688 places of the half axis: the shares
  // are within 1e-9 of the exact ones. place(u) is in (-radius, radius) and never falls as u rises.
  double share_below(double x_px) const;
  double place(double u) const;

  double splat_gain() const;       // (square / integral^2)^2: independent samples of density spp, weighted by f
  double importance_gain() const;  // (absolute / integral)^4: spp places drawn from |f|, weighted by the sign
  double uniform_gain() const;     // (2 radius square / integral^2)^2: spp uniform places, weighted by f

 private:
  // A cell of the half axis: |f| is taken to be linear in it, and its integral to be the exact one.
  struct Cell {
    double below = 0;            // share of the half axis' integral of |f| before it
    double first = 0, last = 0;  // |f| at its ends
  };
  double cell_share(const Cell& cell, const Cell& next, double t) const;

  ReconstructionKernel kernel_;
  double scale_, radius_px_;
  std::vector<double> knots_px_;
  double integral_ = 0, absolute_ = 0, square_ = 0;
  double cell_width_px_ = 0;
  std::vector<Cell> cells_;  // and one past the end, whose `below` is 1
  std::vector<int> guide_;   // for each of as many equal parts of [0, 1): the cell in which it begins
};

}  // namespace triad
