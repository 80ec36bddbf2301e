// SPDX-License-Identifier: Apache-2.0
// A part of both pictures is made into planes of YCxCz once for each exposure: the reference, and what the test
// picture has more. The filters of colours are linear, so they are run over these two: colours that differ by little
// then differ by little with all their digits. Each output row is filtered downwards into rows that stay in the first
// cache, then along these, and judged there.
#include <algorithm>
#include <array>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/evaluation/flip.hpp>
#include <triad/evaluation/internal/flip_filtering.hpp>
#include <triad/numeric/lanes.hpp>

namespace triad {
namespace {

using namespace flip;

// Of linear sRGB light to XYZ, divided by that of white; sRGB's primaries and D65 as rational numbers.
constexpr double kToXyz[3][3] = {{10135552. / 23359437, 8788810. / 23359437, 4435075. / 23359437},
                                 {2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897},
                                 {1425312. / 80288307, 8788810. / 80288307, 70074185. / 80288307}};

using Matrix = std::array<std::array<float, 3>, 3>;

// The three exponents and limits of the paper's section 4.1.3 (q_c, p_c, p_t); q_f of section 4.3 is 1/2.
constexpr float kColourExponent = .7f, kCompressed = .4f, kCompressedTo = .95f;

constexpr double kDelta = 6. / 29;  // of CIELAB, where its cube root becomes straight

struct Constants {
  Matrix to_opponent;    // linear RGB to Y, X - Y, Y - Z over those of white: YCxCz without its scale
  Matrix from_opponent;  // and back
  Matrix to_xyz;
  float limit;        // of the colour difference to the power of q_c, below which errors are stretched
  float below;        // by this factor,
  float above, base;  // and above which they are compressed
};

double lab_curve(double t) {
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4. / 29;
}

// The largest difference there is, of green and blue: CIELAB after Hunt's adjustment, city-block in lightness and
// Euclidean in the rest (HyAB).
double largest_difference() {
  double lab[2][3];
  for (size_t i = 0; i < 2; ++i) {
    const size_t c = i + 1;
    const double x = lab_curve(kToXyz[0][c]), y = lab_curve(kToXyz[1][c]), z = lab_curve(kToXyz[2][c]);
    const double lightness = 116 * y - 16;
    lab[i][0] = lightness;
    lab[i][1] = .01 * lightness * 500 * (x - y);
    lab[i][2] = .01 * lightness * 200 * (y - z);
  }
  return std::abs(lab[0][0] - lab[1][0]) + std::hypot(lab[0][1] - lab[1][1], lab[0][2] - lab[1][2]);
}

Constants make_constants() {
  Constants k{};
  double inverse[3][3];
  const auto minor = [](size_t r, size_t c) {
    const size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return kToXyz[r1][c1] * kToXyz[r2][c2] - kToXyz[r1][c2] * kToXyz[r2][c1];
  };
  double determinant = 0;
  for (size_t c = 0; c < 3; ++c) determinant += kToXyz[0][c] * minor(0, c);
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) inverse[r][c] = minor(c, r) / determinant;
  for (size_t c = 0; c < 3; ++c) {
    const double x = kToXyz[0][c], y = kToXyz[1][c], z = kToXyz[2][c];
    k.to_opponent[0][c] = static_cast<float>(y);
    k.to_opponent[1][c] = static_cast<float>(x - y);
    k.to_opponent[2][c] = static_cast<float>(y - z);
    for (size_t r = 0; r < 3; ++r) k.to_xyz[r][c] = static_cast<float>(kToXyz[r][c]);
    k.from_opponent[c][0] = static_cast<float>(inverse[c][0] + inverse[c][1] + inverse[c][2]);
    k.from_opponent[c][1] = static_cast<float>(inverse[c][0]);
    k.from_opponent[c][2] = static_cast<float>(-inverse[c][2]);
  }
  const double most = std::pow(largest_difference(), static_cast<double>(kColourExponent));
  const double limit = static_cast<double>(kCompressed) * most, to = static_cast<double>(kCompressedTo);
  k.limit = static_cast<float>(limit);
  k.below = static_cast<float>(to / limit);
  k.above = static_cast<float>((1 - to) / (most - limit));
  k.base = static_cast<float>(to - limit * (1 - to) / (most - limit));
  return k;
}

const Constants& constants() {
  static const Constants k = make_constants();
  return k;
}

template <class V>
struct Three {
  V x, y, z;
};

template <class V>
TRIAD_INLINE_BODY inline Three<V> times(const Matrix& m, const Three<V>& v) {
  return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
          m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

// ---- light to opponent colours

// x^2.4 as x^2 x^.4: fewer digits are lost.
template <class V>
TRIAD_INLINE_BODY inline V decoded(const V& code) {
  const V u = larger((code + .055f) * (1 / 1.055f), lanes_of<V>(.05f));
  return code > .04045f ? u * u * exp2_of<V>(.4f * log2_of(u)) : code * (1 / 12.92f);
}

// What the display shows of the light of one exposure.
struct Display {
  bool srgb_codes, tone_maps, by_luminance;
  float exposure;
  FlipToneCurve curve;
};

template <class V>
TRIAD_INLINE_BODY inline V toned(const FlipToneCurve& t, const V& c) {
  const V square = c * c;
  return (square * t.n2 + c * t.n1 + t.n0) / (square * t.d2 + c * t.d1 + t.d0);
}

template <class V>
TRIAD_INLINE_BODY inline Three<V> displayed(const Display& d, const Three<V>& picture) {
  Three<V> c = picture;
  if (d.srgb_codes) c = {decoded(c.x), decoded(c.y), decoded(c.z)};
  if (d.tone_maps) {
    c = {c.x * d.exposure, c.y * d.exposure, c.z * d.exposure};
    if (d.by_luminance) {
      const V factor = 1.f / (1.f + (.2126f * c.x + .7152f * c.y + .0722f * c.z));
      c = {c.x * factor, c.y * factor, c.z * factor};
    } else {
      c = {toned(d.curve, c.x), toned(d.curve, c.y), toned(d.curve, c.z)};
    }
  }
  return {to_unit(c.x), to_unit(c.y), to_unit(c.z)};
}

// Planes: Y, Cx, Cz of the reference, the same of test - reference, and Y of the test.
constexpr size_t kPlanes = 7;

// As the authors' program rounds it: see in_order().
template <class V>
TRIAD_INLINE_BODY inline V light_of(const V& y) {
  return (116.f * y - 16.f) * (1.f / 116.f) + 16.f / 116.f;
}

// n pixels of both pictures, 3 planes of stride floats each, to a row of each of the planes.
template <class V>
TRIAD_INLINE_BODY inline void convert(const Display& display, const float* reference, const float* test,
                                      size_t stride, int n, float* to, size_t plane) {
  const Constants& k = constants();
  for (int x = 0; x < n; x += kLanes<V>) {
    const auto at = [&](const float* rgb) {
      return Three<V>{load<V>(rgb + x), load<V>(rgb + stride + x), load<V>(rgb + 2 * stride + x)};
    };
    const Three<V> r = times(k.to_opponent, displayed(display, at(reference)));
    const Three<V> t = times(k.to_opponent, displayed(display, at(test)));
    store(to + x, light_of(r.x));
    store(to + plane + x, r.y);
    store(to + 2 * plane + x, r.z);
    store<V>(to + 3 * plane + x, t.x - r.x);
    store<V>(to + 4 * plane + x, t.y - r.y);
    store<V>(to + 5 * plane + x, t.z - r.z);
    store(to + 6 * plane + x, light_of(t.x));
  }
}

// ---- differences. In short loops over a few pixels in the first cache: each step waits long for the one before, and
// a processor looks ahead over several turns of a short loop, not over one of a long.

constexpr int kChunk_px = 128;
using Row = float[kChunk_px];

// What the eye keeps of a pixel's neighbourhood: colour, and how strong edges and points are along and across.
struct Seen {
  alignas(64) Row opponent[3];
  alignas(64) Row edge_x, edge_y, point_x, point_y;
};

template <class V>
TRIAD_INLINE_BODY inline void filter_row(const Filters& f, const float* rows, size_t stride, int n, Seen& s) {
  even<V>(f.achromatic, rows + kY * stride, 1, n, s.opponent[0]);
  even<V>(f.red_green, rows + kCx * stride, 1, n, s.opponent[1]);
  even<V>(f.wide, rows + kCzWide * stride, 1, n, s.opponent[2]);
  even<V, true>(f.narrow, rows + kCzNarrow * stride, 1, n, s.opponent[2]);
  derivatives<V, false>(f, rows + kGaussian * stride, 1, n, s.edge_x, s.point_x, nullptr);
  in_order<V>(f.gaussian, f.feature_radius, rows + kFirst * stride, n, s.edge_y);
  in_order<V>(f.gaussian, f.feature_radius, rows + kSecond * stride, n, s.point_y);
}

// The light that is seen, cut to what a display shows, as XYZ, and its change from the reference to the test. Where
// neither is cut, the change keeps its digits.
template <class V>
TRIAD_INLINE_BODY inline void to_light(Row* reference, Row* difference, int n) {
  const Constants& k = constants();
  for (int x = 0; x < n; x += kLanes<V>) {
    const auto at = [&](const Row* rows) TRIAD_INLINE_BODY {
      return Three<V>{load<V>(rows[0] + x), load<V>(rows[1] + x), load<V>(rows[2] + x)};
    };
    const auto put = [&](Row* rows, const Three<V>& v) TRIAD_INLINE_BODY {
      store(rows[0] + x, v.x);
      store(rows[1] + x, v.y);
      store(rows[2] + x, v.z);
    };
    Three<V> rgb = times(k.from_opponent, at(reference)), change = times(k.from_opponent, at(difference));
    const auto cut = [](V& value, V& by) TRIAD_INLINE_BODY {
      const V other = value + by, value_cut = to_unit(value), other_cut = to_unit(other);
      const V off = abs_of<V>(value - value_cut) + abs_of<V>(other - other_cut);
      by = off > 0.f ? other_cut - value_cut : by;
      value = value_cut;
    };
    cut(rgb.x, change.x);
    cut(rgb.y, change.y);
    cut(rgb.z, change.z);
    put(reference, times(k.to_xyz, rgb));
    put(difference, times(k.to_xyz, change));
  }
}

// The cube root of CIELAB with its straight piece near black, in place, and its change.
template <class V>
TRIAD_INLINE_BODY inline void lab_curve(float* values, float* changes, int n) {
  constexpr auto kCube = static_cast<float>(kDelta * kDelta * kDelta);
  constexpr auto kSlope = static_cast<float>(1 / (3 * kDelta * kDelta)), kOffset = static_cast<float>(4. / 29);
  const V cube = lanes_of<V>(kCube);
  for (int x = 0; x < n; x += kLanes<V>) {
    const V reference = load<V>(values + x), difference = load<V>(changes + x), test = reference + difference;
    const V r = cbrt_of(larger(reference, cube)), t = cbrt_of(larger(test, cube));
    const V value = reference > cube ? r : kSlope * reference + kOffset;
    const V other = test > cube ? t : kSlope * test + kOffset;
    // Of two roots, and of two points on the line, the difference follows from that of the arguments.
    const V high = reference > test ? reference : test, low = reference > test ? test : reference;
    const V of_lines = high > cube ? other - value : kSlope * difference;
    store(values + x, value);
    store<V>(changes + x, low > cube ? difference / (r * r + r * t + t * t) : of_lines);
  }
}

// The HyAB distance after Hunt's adjustment, chroma times lightness / 100, whose change is made of changes, too.
template <class V>
TRIAD_INLINE_BODY inline void distance(const Row* values, const Row* changes, int n, float* to) {
  for (int i = 0; i < n; i += kLanes<V>) {
    const V x = load<V>(values[0] + i), y = load<V>(values[1] + i), z = load<V>(values[2] + i);
    const V dx = load<V>(changes[0] + i), dy = load<V>(changes[1] + i), dz = load<V>(changes[2] + i);
    const V lightness_change = 116.f * dy, lightness_test = 116.f * (y + dy) - 16.f;
    const V a_change = 5.f * (lightness_change * (x - y) + lightness_test * (dx - dy));
    const V b_change = 2.f * (lightness_change * (y - z) + lightness_test * (dy - dz));
    store<V>(to + i, abs_of(lightness_change) + sqrt_of<V>(a_change * a_change + b_change * b_change));
  }
}

constexpr float kNothing = 1e-30f;  // a difference that is none, and of which there is a logarithm

// The colour difference from 0 to 1: section 4.1.
template <class V>
TRIAD_INLINE_BODY inline void colour_difference(float* distances, int n) {
  const Constants& k = constants();
  for (int x = 0; x < n; x += kLanes<V>) {
    const V power = exp2_of<V>(kColourExponent * log2_of(larger(load<V>(distances + x), lanes_of<V>(kNothing))));
    store<V>(distances + x, power < k.limit ? power * k.below : power * k.above + k.base);
  }
}

// The feature difference from 0 to 1: section 4.2.
template <class V>
TRIAD_INLINE_BODY inline void feature_difference(const Seen& reference, const Seen& test, int n, float* to) {
  for (int i = 0; i < n; i += kLanes<V>) {
    const auto strength = [&](const float* along, const float* across) TRIAD_INLINE_BODY {
      const V x = load<V>(along + i), y = load<V>(across + i);
      return sqrt_of<V>(x * x + y * y);
    };
    const V edge = abs_of<V>(strength(test.edge_x, test.edge_y) - strength(reference.edge_x, reference.edge_y));
    const V point = abs_of<V>(strength(test.point_x, test.point_y) - strength(reference.point_x, reference.point_y));
    store<V>(to + i, sqrt_of<V>(.707106781f * larger(edge, point)));
  }
}

// Errors: section 4.3, colour to the power of 1 - feature. What is larger than before is kept.
template <class V>
TRIAD_INLINE_BODY inline void combine(const float* colours, const float* features, int n, float exposure_stops,
                                      float* errors, float* worst_stops) {
  constexpr float kNoColour = 1e-20f;  // above what kNothing gives
  for (int x = 0; x < n; x += kLanes<V>) {
    const V colour = load<V>(colours + x), before = load<V>(errors + x);
    const V error = exp2_of<V>((1.f - load<V>(features + x)) * log2_of(colour));
    const V now = colour > kNoColour ? error : V{};
    store<V>(errors + x, now > before ? now : before);
    if (worst_stops) store<V>(worst_stops + x, now > before ? lanes_of<V>(exposure_stops) : load<V>(worst_stops + x));
  }
}

// The columns of the reference, and of the difference with the features of the test, from pixel 0 of a row on.
template <class V>
TRIAD_INLINE_BODY inline void judge(const Filters& f, const float* reference, const float* difference, size_t stride,
                                    int width, float exposure_stops, float* errors, float* worst_stops) {
  Seen r, d;
  alignas(64) Row colours, features;
  for (int x = 0; x < width; x += kChunk_px) {
    const int n = std::min(kChunk_px, width - x);
    filter_row<V>(f, reference + x, stride, n, r);
    filter_row<V>(f, difference + x, stride, n, d);
    to_light<V>(r.opponent, d.opponent, n);
    for (size_t c = 0; c < 3; ++c) lab_curve<V>(r.opponent[c], d.opponent[c], n);
    distance<V>(r.opponent, d.opponent, n, colours);
    colour_difference<V>(colours, n);
    feature_difference<V>(r, d, n, features);
    combine<V>(colours, features, n, exposure_stops, errors + x, worst_stops ? worst_stops + x : nullptr);
  }
}

// Columns are worked on in groups.
constexpr int kGroup_px = kTogether * kMostLanes;
int in_groups(int n) { return (n + kGroup_px - 1) / kGroup_px * kGroup_px; }

// How a part lies in the memory that it is computed in. Pixel 0 of each row is at a boundary of cache lines.
struct Arrangement {
  int reach, pad, rows, columns;
  size_t stride, plane;  // vectors that begin before a row's last pixel end in it
  Arrangement(int reach_px, int width, int height)
      : reach(reach_px),
        pad((reach_px + kMostLanes - 1) / kMostLanes * kMostLanes),
        rows(height + 2 * reach_px),
        columns(in_groups(2 * pad + width)),
        stride(static_cast<size_t>(columns + kGroup_px)),
        plane(stride * static_cast<size_t>(rows)) {}
  size_t floats() const { return kPlanes * plane + (2 * 3 + 2 * kColumns) * stride; }
};

void take_apart(const float* rgb, int n, float* planes, size_t stride) {
  run_widest([&]() TRIAD_INLINE_BODY {
    float *r = planes, *g = planes + stride, *b = planes + 2 * stride;
    for (int i = 0; i < n; ++i) {
      r[i] = rgb[3 * i];
      g[i] = rgb[3 * i + 1];
      b[i] = rgb[3 * i + 2];
    }
  });
}

}  // namespace

Flip::Flip(double ppd) : filters_(ppd) {}

int Flip::row_floats(int width) { return in_groups(width); }

size_t Flip::work_floats(int width, int height) const { return Arrangement(reach_px(), width, height).floats(); }

void Flip::evaluate(const FlipPicture& test, const FlipPicture& reference, int width, int height,
                    const FlipViewing& viewing, float* errors, float* worst_stops, float* work) const {
  const Arrangement at(reach_px(), width, height);
  const Filters filters{taps(filters_.achromatic),         taps(filters_.red_green),
                        taps(filters_.blue_yellow_wide),   taps(filters_.blue_yellow_narrow),
                        filters_.gaussian.data(),          filters_.first_derivative.data(),
                        filters_.second_derivative.data(), static_cast<int>(filters_.gaussian.size() / 2)};
  float* const planes = work;
  float* const rgb = planes + kPlanes * at.plane;
  float* const columns = rgb + 6 * at.stride;
  // What lies beyond the pixels is computed with, though nobody looks at the result.
  std::fill_n(work, at.floats(), 0.f);

  const std::vector<float> as_it_is{0};
  const std::vector<float>& exposures = viewing.exposures_stops.empty() ? as_it_is : viewing.exposures_stops;
  const size_t results = static_cast<size_t>(in_groups(width)) * static_cast<size_t>(height);
  std::fill_n(errors, results, 0.f);
  if (worst_stops) std::fill_n(worst_stops, results, exposures.front());

  const int past = in_groups(width + 2 * at.reach);
  for (const float stops : exposures) {
    const Display display{
        viewing.srgb_codes, !viewing.exposures_stops.empty(), viewing.tone_mapper == FlipToneMapper::kReinhard,
        static_cast<float>(std::exp2(static_cast<double>(stops))), flip_tone_curve(viewing.tone_mapper)};
    for (int row = 0; row < at.rows; ++row) {
      const auto pixels = [&](const FlipPicture& p) {
        return p.rgb + (row - at.reach) * p.row_floats - 3 * at.reach;
      };
      take_apart(pixels(reference), width + 2 * at.reach, rgb, at.stride);
      take_apart(pixels(test), width + 2 * at.reach, rgb + 3 * at.stride, at.stride);
      float* const to = planes + static_cast<size_t>(row) * at.stride + at.pad - at.reach;
      run_lanes([&]<class V>() TRIAD_INLINE_BODY {
        convert<V>(display, rgb, rgb + 3 * at.stride, at.stride, past, to, at.plane);
      });
    }
    for (int row = 0; row < height; ++row) {
      const float* const centre = planes + static_cast<size_t>(row + at.reach) * at.stride;
      float* const difference = columns + kColumns * at.stride;
      const ptrdiff_t step = static_cast<ptrdiff_t>(at.stride);
      const size_t result = static_cast<size_t>(row) * static_cast<size_t>(in_groups(width));
      run_lanes([&]<class V>() TRIAD_INLINE_BODY {
        filter_columns<V>(filters, centre, centre, at.plane, step, at.columns, columns, at.stride);
        filter_columns<V>(filters, centre + 3 * at.plane, centre + 6 * at.plane, at.plane, step, at.columns,
                          difference, at.stride);
      });
      run_lanes([&]<class V>() TRIAD_INLINE_BODY {
        judge<V>(filters, columns + at.pad, difference + at.pad, at.stride, width, stops, errors + result,
                 worst_stops ? worst_stops + result : nullptr);
      });
    }
  }
}

}  // namespace triad
