// SPDX-License-Identifier: Apache-2.0
// Fresnel integrals.
#pragma once

#include <complex>

namespace triad {

// C(z) + i S(z), the integral of exp(i pi t^2 / 2) from 0 to z, within 1e-15 + 1e-16 z^2 for all finite z.
// By the power series (DLMF 7.6.4 and 7.6.6) up to |z| = 2, beyond by C + iS = (1 + i) / 2 erf(w) with
// w = sqrt(pi) / 2 (1 - i) z (DLMF 7.5.8) and the continued fraction of erfc (DLMF 7.9.1).
std::complex<double> fresnel(double z);

// The mean of exp(i a t^2) for t in [t0, t1]; a > 0.
std::complex<double> mean_chirp(double a, double t0, double t1);

}  // namespace triad
