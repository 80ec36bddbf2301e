// SPDX-License-Identifier: Apache-2.0
// Separable filters of FLIP over rows of floats, several vectors at a time. They read as far beyond the values that
// they make as their radius, and write whole groups of vectors.
#pragma once

#include <cstddef>
#include <triad/numeric/lanes.hpp>
#include <vector>

namespace triad::flip {

// An even filter: weights[k] at both distances k from the centre.
struct Taps {
  const float* weights;
  int radius;
};
inline Taps taps(const std::vector<float>& half) { return {half.data(), static_cast<int>(half.size()) - 1}; }

struct Filters {
  Taps achromatic, red_green, wide, narrow;
  const float *gaussian, *first, *second;  // whole, from -feature_radius on
  int feature_radius;
};

// Vectors that are filtered together: one load of a weight serves them all, and their sums do not wait for each
// other.
constexpr int kTogether = 2;

template <class V>
struct Group {
  V v[kTogether];
};
template <class V>
TRIAD_INLINE_BODY inline Group<V> load_group(const float* from) {
  Group<V> g;
  for (int i = 0; i < kTogether; ++i) g.v[i] = load<V>(from + i * kLanes<V>);
  return g;
}
template <class V>
TRIAD_INLINE_BODY inline void store_group(float* to, const Group<V>& g) {
  for (int i = 0; i < kTogether; ++i) store(to + i * kLanes<V>, g.v[i]);
}
// n values of an even filter over values that are `step` floats apart. Added to what is there with kAdd.
template <class V, bool kAdd = false>
TRIAD_INLINE_BODY inline void even(const Taps& t, const float* from, ptrdiff_t step, int n, float* to) {
  for (int x = 0; x < n; x += kTogether * kLanes<V>) {
    Group<V> sum = load_group<V>(from + x);
    for (V& v : sum.v) v *= t.weights[0];
    for (int k = 1; k <= t.radius; ++k) {
      const Group<V> before = load_group<V>(from + x - k * step), after = load_group<V>(from + x + k * step);
      for (int i = 0; i < kTogether; ++i) sum.v[i] += t.weights[k] * (before.v[i] + after.v[i]);
    }
    if constexpr (kAdd) {
      const Group<V> there = load_group<V>(to + x);
      for (int i = 0; i < kTogether; ++i) sum.v[i] += there.v[i];
    }
    store_group(to + x, sum);
  }
}

// Filters of features, their products added from left to right or top to bottom. Where a picture is flat the rounding
// of these sums is all that is left of a derivative, and the root that is taken of it in the end makes 1e-7 to 3e-4:
// the authors' program adds in this order, and agrees in flat areas, too.
template <class V>
TRIAD_INLINE_BODY inline void in_order(const float* weights, int radius, const float* from, int n, float* to) {
  for (int x = 0; x < n; x += kTogether * kLanes<V>) {
    Group<V> sum{};
    for (int k = -radius; k <= radius; ++k) {
      const Group<V> value = load_group<V>(from + x + k);
      for (int i = 0; i < kTogether; ++i) sum.v[i] += weights[k + radius] * value.v[i];
    }
    store_group(to + x, sum);
  }
}

// Both derivatives, and with kBlurs the Gaussian.
template <class V, bool kBlurs>
TRIAD_INLINE_BODY inline void derivatives(const Filters& f, const float* from, ptrdiff_t step, int n, float* first_to,
                                          float* second_to, float* gaussian_to) {
  for (int x = 0; x < n; x += kTogether * kLanes<V>) {
    Group<V> first{}, second{}, gaussian{};
    for (int k = -f.feature_radius; k <= f.feature_radius; ++k) {
      const Group<V> value = load_group<V>(from + x + k * step);
      const int w = k + f.feature_radius;
      for (int i = 0; i < kTogether; ++i) {
        first.v[i] += f.first[w] * value.v[i];
        second.v[i] += f.second[w] * value.v[i];
        if constexpr (kBlurs) gaussian.v[i] += f.gaussian[w] * value.v[i];
      }
    }
    store_group(first_to + x, first);
    store_group(second_to + x, second);
    if constexpr (kBlurs) store_group(gaussian_to + x, gaussian);
  }
}

template <class V>
TRIAD_INLINE_BODY inline void two_even(const Taps& one, const Taps& other, const float* from, ptrdiff_t step, int n,
                                       float* one_to, float* other_to) {
  for (int x = 0; x < n; x += kTogether * kLanes<V>) {
    const Group<V> centre = load_group<V>(from + x);
    Group<V> a, b;
    for (int i = 0; i < kTogether; ++i) {
      a.v[i] = one.weights[0] * centre.v[i];
      b.v[i] = other.weights[0] * centre.v[i];
    }
    for (int k = 1; k <= one.radius; ++k) {
      const Group<V> before = load_group<V>(from + x - k * step), after = load_group<V>(from + x + k * step);
      for (int i = 0; i < kTogether; ++i) {
        const V sum = before.v[i] + after.v[i];
        a.v[i] += one.weights[k] * sum;
        b.v[i] += other.weights[k] * sum;
      }
    }
    store_group(one_to + x, a);
    store_group(other_to + x, b);
  }
}

// What the columns of a picture's planes are filtered to.
enum Column : size_t { kY, kCx, kCzWide, kCzNarrow, kGaussian, kFirst, kSecond, kColumns };

// One row, downwards: colours from three planes in a row, features from `light`.
template <class V>
TRIAD_INLINE_BODY inline void filter_columns(const Filters& f, const float* colours, const float* light, size_t plane,
                                             ptrdiff_t step, int n, float* to, size_t stride) {
  even<V>(f.achromatic, colours, step, n, to + kY * stride);
  even<V>(f.red_green, colours + plane, step, n, to + kCx * stride);
  two_even<V>(f.wide, f.narrow, colours + 2 * plane, step, n, to + kCzWide * stride, to + kCzNarrow * stride);
  derivatives<V, true>(f, light, step, n, to + kFirst * stride, to + kSecond * stride, to + kGaussian * stride);
}

}  // namespace triad::flip
