// SPDX-License-Identifier: Apache-2.0
// The steps of the constrained solver on arrays: what RowSolver and PlaneSolver have in common.
//
// Everything is relative to the displaced box: y = a - box, so that a flat picture is all zeros and floats keep
// their digits. One state s per drive; z = s clamped to [-box, 1 - box] is the displayable drive. One iteration:
//
//   v = rho (2 z - s),  x = K (b + v) with K = (A + rho)^-1 per tile frequency,  s += 1.7 (x - z)
//
// which is over-relaxed ADMM with its z and its u = s - z in one variable. rho_e = rho D_e. Spectra are those of
// half the torus, interleaved complex; a plane of drives or of its spectrum lies `stride` elements after the one
// before.
#pragma once

#include <algorithm>
#include <complex>
#include <cstddef>
#include <limits>
#include <triad/display/constrained.hpp>
#include <vector>

namespace triad::descent {

inline constexpr double kRelaxation = 1.7;
inline constexpr double kPenaltyShare = .6;  // rho = .6 lambda: fastest over the pictures and ppds of the tests
// Below this lambda the penalty stays: with none the step would not be defined.
inline constexpr double kLeastPenaltyLambda = 1e-3;
// rho over D.
inline double penalty(double lambda) { return kPenaltyShare * std::max(lambda, kLeastPenaltyLambda); }
// J / T below this is the rounding of Real: an error of 1e-6 in floats, that nobody sees and no step improves.
template <class Real>
constexpr double negligible() {
  constexpr double kEpsilon = std::numeric_limits<Real>::epsilon();
  return 100 * kEpsilon * kEpsilon;
}
// Iterations before the first certificate, and from one to the next; each costs half an iteration.
inline constexpr int kFirstCheck = 10, kCheckEvery = 5;

// Sums over drives at a certificate, from which and from two quadratic forms J(z) and the gap follow.
struct Sums {
  double mu_z = 0;    // mu z
  double slack = 0;   // phi(z) - min phi, phi(a) = -2 mu (a - x) + floor (a - x)^2
  double square = 0;  // floor (z - x)^2
  void add(const Sums& other);
};

// s and the next v from x, for n drives of one emitter.
template <class Real>
void advance(size_t n, const Real* x, const Real* box, Real rho, Real* state, Real* next);
// As advance, but z - x instead of v, and the sums. penalty: rho_e without 1 / T.
template <class Real>
Sums advance_certified(size_t n, const Real* x, const Real* box, Real penalty, Real floor, Real* state,
                       Real* difference);
// z from s.
template <class Real>
void project(size_t n, const Real* box, const Real* state, Real* z);
// The drives: box + z, within [0, 1] whatever rounding did.
template <class Real>
void displayable(size_t n, const Real* box, const Real* z, Real* drives);

// x = h + K v in place of v, for n frequencies of E emitters. K packed as HermitianTable.
template <class Real>
void apply(int E, size_t n, const Real* K, size_t K_stride, const std::complex<Real>* h, size_t h_stride,
           std::complex<Real>* v, size_t v_stride);
// out = scale K b.
template <class Real>
void multiply(int E, size_t n, Real scale, const Real* K, size_t K_stride, const std::complex<Real>* b,
              size_t b_stride, std::complex<Real>* out, size_t out_stride);
// sum of share[i] x^H A x.
template <class Real>
double quadratic(int E, size_t n, const Real* A, size_t A_stride, const std::complex<Real>* x, size_t x_stride,
                 const Real* share);

// One alias and one channel of n frequencies: r = target - keep P l box; b += conj(l) P W r; energy += W |r|^2.
// Arrays of E planes (light, box, b) have re and im apart, [e * stride + i].
template <class Real>
struct Residual {
  int E;
  int n, stride;
  const Real *light_re, *light_im, *box_re, *box_im, *keep, *weight, *target_re, *target_im;
  const Real* P;  // [e]
  Real *b_re, *b_im, *energy;
  void add() const;
};

// 1 or 2 for each frequency mx of half a spectrum: how often it stands in the whole one.
template <class Real>
std::vector<Real> half_shares(int tiles_x);

// Folds a certificate into the result; true when z is the best so far.
bool certify(SolveResult& result, double quadratic_x, double quadratic_d, const Sums& sums, double tiles,
             double tolerance);

}  // namespace triad::descent
