// SPDX-License-Identifier: Apache-2.0
// A part of both pictures is made into planes of YCxCz once for each exposure: the reference, and what the test picture
// has more. All filters are linear, so they are run over these two: colours that differ by little then differ by
// little with all their digits. Each output row is filtered downwards into rows that stay in the first cache, then
// along these, and judged while it is in registers.
#include <algorithm>
#include <array>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/evaluation/flip.hpp>
#include <triad/numeric/lanes.hpp>

namespace triad {
namespace {

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

double lab_curve(double t) { return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4. / 29; }

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
TRIAD_INLINE_BODY inline Three<V> displayed(const Display& d, Three<V> c) {
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

// Planes in the order of a row's places: Y, Cx, Cz of the reference, then of test - reference.
constexpr size_t kPlanes = 6;

// n pixels of both pictures, 3 planes of stride floats each, to a row of each of the six planes.
template <class V>
TRIAD_INLINE_BODY inline void convert(const Display& display, const float* reference, const float* test, size_t stride,
                                      int n, float* to, size_t plane) {
  const Constants& k = constants();
  for (int x = 0; x < n; x += kLanes<V>) {
    const auto at = [&](const float* rgb) {
      return Three<V>{load<V>(rgb + x), load<V>(rgb + stride + x), load<V>(rgb + 2 * stride + x)};
    };
    const Three<V> r = times(k.to_opponent, displayed(display, at(reference)));
    const Three<V> t = times(k.to_opponent, displayed(display, at(test)));
    store(to + x, r.x);
    store(to + plane + x, r.y);
    store(to + 2 * plane + x, r.z);
    store<V>(to + 3 * plane + x, t.x - r.x);
    store<V>(to + 4 * plane + x, t.y - r.y);
    store<V>(to + 5 * plane + x, t.z - r.z);
  }
}

// ---- filters, around `at`, over values that are `step` floats apart

struct Taps {
  const float* weights;
  int radius;
};
Taps taps(const std::vector<float>& half) { return {half.data(), static_cast<int>(half.size()) - 1}; }

template <class V>
TRIAD_INLINE_BODY inline V even(const float* at, ptrdiff_t step, const Taps& t) {
  V sum = t.weights[0] * load<V>(at);
  for (int k = 1; k <= t.radius; ++k) sum += t.weights[k] * (load<V>(at - k * step) + load<V>(at + k * step));
  return sum;
}

template <class V>
TRIAD_INLINE_BODY inline V odd(const float* at, ptrdiff_t step, const Taps& t) {
  V sum{};
  for (int k = 1; k <= t.radius; ++k) sum += t.weights[k] * (load<V>(at + k * step) - load<V>(at - k * step));
  return sum;
}

struct Filters {
  Taps achromatic, red_green, wide, narrow, gaussian, first, second;
};

// What the columns of a plane are filtered to.
enum Column : size_t { kY, kCx, kCzWide, kCzNarrow, kGaussian, kFirst, kSecond, kColumns };

// One row of the planes of one picture, downwards. The weights of the second derivative sum to 0, so that it may be
// taken of differences from the centre: like the first it is then exactly 0 where nothing changes.
template <class V>
TRIAD_INLINE_BODY inline void filter_columns(const Filters& f, const float* from, size_t plane, ptrdiff_t step, int n,
                                             float* to, size_t stride) {
  for (int x = 0; x < n; x += kLanes<V>) {
    const float* y = from + x;
    const V centre = load<V>(y), twice = centre + centre;
    V achromatic = f.achromatic.weights[0] * centre, gaussian = f.gaussian.weights[0] * centre, first{}, second{};
    const auto add = [&](int k, const V& above, const V& below) TRIAD_INLINE_BODY {
      const V sum = above + below;
      gaussian += f.gaussian.weights[k] * sum;
      first += f.first.weights[k] * (below - above);
      second += f.second.weights[k] * (sum - twice);
      return sum;
    };
    int k = 1;
    for (; k <= f.achromatic.radius; ++k)
      achromatic += f.achromatic.weights[k] * add(k, load<V>(y - k * step), load<V>(y + k * step));
    for (; k <= f.gaussian.radius; ++k) add(k, load<V>(y - k * step), load<V>(y + k * step));
    store(to + kY * stride + x, achromatic);
    store(to + kGaussian * stride + x, gaussian);
    store(to + kFirst * stride + x, first);
    store(to + kSecond * stride + x, second);
    store(to + kCx * stride + x, even<V>(from + plane + x, step, f.red_green));

    const float* z = from + 2 * plane + x;
    V wide = f.wide.weights[0] * load<V>(z), narrow = f.narrow.weights[0] * load<V>(z);
    for (k = 1; k <= f.wide.radius; ++k) {
      const V sum = load<V>(z - k * step) + load<V>(z + k * step);
      wide += f.wide.weights[k] * sum;
      narrow += f.narrow.weights[k] * sum;
    }
    store(to + kCzWide * stride + x, wide);
    store(to + kCzNarrow * stride + x, narrow);
  }
}

// What the eye keeps of a pixel's neighbourhood: colour, and how strong edges and points are along and across.
template <class V>
struct Seen {
  Three<V> opponent;
  V edge_x, edge_y, point_x, point_y;
};

template <class V>
TRIAD_INLINE_BODY inline Seen<V> filter_row(const Filters& f, const float* rows, size_t stride) {
  Seen<V> s;
  s.opponent.x = even<V>(rows + kY * stride, 1, f.achromatic);
  s.opponent.y = even<V>(rows + kCx * stride, 1, f.red_green);
  s.opponent.z = even<V>(rows + kCzWide * stride, 1, f.wide) + even<V>(rows + kCzNarrow * stride, 1, f.narrow);
  const float* y = rows + kGaussian * stride;
  const V centre = load<V>(y), twice = centre + centre;
  s.edge_x = s.point_x = V{};
  for (int k = 1; k <= f.first.radius; ++k) {
    const V left = load<V>(y - k), right = load<V>(y + k);
    s.edge_x += f.first.weights[k] * (right - left);
    s.point_x += f.second.weights[k] * (left + right - twice);
  }
  s.edge_y = even<V>(rows + kFirst * stride, 1, f.gaussian);
  s.point_y = even<V>(rows + kSecond * stride, 1, f.gaussian);
  return s;
}

// ---- differences

// The cube root of CIELAB with its straight piece near black, of one picture, and its change to the other.
template <class V>
struct LabCurve {
  V value, change;
};
template <class V>
TRIAD_INLINE_BODY inline LabCurve<V> lab_curve(const V& reference, const V& difference) {
  constexpr auto kCube = static_cast<float>(kDelta * kDelta * kDelta);
  constexpr auto kSlope = static_cast<float>(1 / (3 * kDelta * kDelta)), kOffset = static_cast<float>(4. / 29);
  const V cube = lanes_of<V>(kCube), test = reference + difference;
  const V r = cbrt_of(larger(reference, cube)), t = cbrt_of(larger(test, cube));
  const V r_line = kSlope * reference + kOffset, t_line = kSlope * test + kOffset;
  const V value = reference > kCube ? r : r_line, other = test > kCube ? t : t_line;
  // Of two roots, and of two points on the line, the difference follows from that of the arguments.
  const auto both_high = (reference > kCube) & (test > kCube), both_low = (reference <= kCube) & (test <= kCube);
  const V of_lines = both_low ? kSlope * difference : other - value;
  return {value, both_high ? difference / (r * r + r * t + t * t) : of_lines};
}

// The colour difference, from 0 to 1: section 4.1.
template <class V>
TRIAD_INLINE_BODY inline V colour_difference(const Constants& k, const Three<V>& reference, const Three<V>& difference) {
  const Three<V> r = times(k.from_opponent, reference), d = times(k.from_opponent, difference);
  // Cut to what a display shows. Where neither is cut, the difference keeps its digits.
  const auto cut = [](V& value, V& change) TRIAD_INLINE_BODY {
    const V other = value + change, value_cut = to_unit(value), other_cut = to_unit(other);
    change = (value == value_cut) & (other == other_cut) ? change : other_cut - value_cut;
    value = value_cut;
  };
  Three<V> rgb = r, change = d;
  cut(rgb.x, change.x);
  cut(rgb.y, change.y);
  cut(rgb.z, change.z);
  const Three<V> xyz = times(k.to_xyz, rgb), xyz_change = times(k.to_xyz, change);
  const LabCurve<V> x = lab_curve(xyz.x, xyz_change.x), y = lab_curve(xyz.y, xyz_change.y),
                    z = lab_curve(xyz.z, xyz_change.z);
  // Hunt's adjustment: chroma times lightness / 100. Its change, too, is made of changes.
  const V lightness = 116.f * y.value - 16.f, lightness_change = 116.f * y.change;
  const V lightness_test = lightness + lightness_change;
  const V a_change =
      5.f * (lightness_change * (x.value - y.value) + lightness_test * (x.change - y.change));
  const V b_change =
      2.f * (lightness_change * (y.value - z.value) + lightness_test * (y.change - z.change));
  const V hyab = abs_of(lightness_change) + sqrt_of<V>(a_change * a_change + b_change * b_change);
  const V power = exp2_of<V>(kColourExponent * log2_of(larger(hyab, lanes_of<V>(1e-30f))));
  const V error = power < k.limit ? power * k.below : power * k.above + k.base;
  return hyab > 1e-30f ? error : V{};
}

// The feature difference, from 0 to 1: section 4.2.
template <class V>
TRIAD_INLINE_BODY inline V feature_difference(const Seen<V>& reference, const Seen<V>& difference) {
  const auto change = [](const V& x, const V& y, const V& dx, const V& dy) TRIAD_INLINE_BODY {
    const V tx = x + dx, ty = y + dy;
    return abs_of<V>(sqrt_of<V>(tx * tx + ty * ty) - sqrt_of<V>(x * x + y * y));
  };
  const V edge = change(reference.edge_x, reference.edge_y, difference.edge_x, difference.edge_y);
  const V point = change(reference.point_x, reference.point_y, difference.point_x, difference.point_y);
  return sqrt_of<V>(.707106781f * larger(edge, point));
}

// A row of errors: section 4.3, colour to the power of 1 - feature. What is larger than before is kept.
template <class V>
TRIAD_INLINE_BODY inline void judge(const Filters& f, const float* reference, const float* difference, size_t stride,
                                    int width, float exposure_stops, float* errors, float* worst_stops) {
  const Constants& k = constants();
  for (int x = 0; x < width; x += kLanes<V>) {
    const Seen<V> r = filter_row<V>(f, reference + x, stride), d = filter_row<V>(f, difference + x, stride);
    const V colour = colour_difference(k, r.opponent, d.opponent), feature = feature_difference(r, d);
    const V error = exp2_of<V>((1.f - feature) * log2_of(larger(colour, lanes_of<V>(1e-30f))));
    const V before = load<V>(errors + x), now = colour > 0.f ? error : V{};
    const auto more = now > before;
    store<V>(errors + x, more ? now : before);
    if (worst_stops) {
      const V stops = load<V>(worst_stops + x);
      store<V>(worst_stops + x, more ? lanes_of<V>(exposure_stops) : stops);
    }
  }
}

int in_lanes(int n) { return (n + kMostLanes - 1) / kMostLanes * kMostLanes; }

// How a part lies in the memory that it is computed in. Column 0 of each row is at a boundary of lanes.
struct Arrangement {
  int reach, pad, rows, columns;
  size_t stride, plane;  // vectors that begin before a row's last pixel end in it
  Arrangement(int reach_px, int width, int height)
      : reach(reach_px),
        pad(in_lanes(reach_px)),
        rows(height + 2 * reach_px),
        columns(2 * pad + in_lanes(width)),
        stride(static_cast<size_t>(columns + kMostLanes)),
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

int Flip::row_floats(int width) { return in_lanes(width); }

size_t Flip::work_floats(int width, int height) const { return Arrangement(reach_px(), width, height).floats(); }

void Flip::evaluate(const FlipPicture& test, const FlipPicture& reference, int width, int height,
                    const FlipViewing& viewing, float* errors, float* worst_stops, float* work) const {
  const Arrangement at(reach_px(), width, height);
  const Filters filters{taps(filters_.achromatic),        taps(filters_.red_green), taps(filters_.blue_yellow_wide),
                        taps(filters_.blue_yellow_narrow), taps(filters_.gaussian),  taps(filters_.first_derivative),
                        taps(filters_.second_derivative)};
  float* const planes = work;
  float* const rgb = planes + kPlanes * at.plane;
  float* const columns = rgb + 6 * at.stride;
  // What lies beyond the pixels is computed with, though nobody looks at the result.
  std::fill_n(work, at.floats(), 0.f);

  const std::vector<float> as_it_is{0};
  const std::vector<float>& exposures = viewing.exposures_stops.empty() ? as_it_is : viewing.exposures_stops;
  const size_t results = static_cast<size_t>(in_lanes(width)) * static_cast<size_t>(height);
  std::fill_n(errors, results, 0.f);
  if (worst_stops) std::fill_n(worst_stops, results, exposures.front());

  const int past = in_lanes(width + 2 * at.reach);
  for (const float stops : exposures) {
    const Display display{viewing.srgb_codes, !viewing.exposures_stops.empty(),
                          viewing.tone_mapper == FlipToneMapper::kReinhard,
                          static_cast<float>(std::exp2(static_cast<double>(stops))),
                          flip_tone_curve(viewing.tone_mapper)};
    for (int row = 0; row < at.rows; ++row) {
      const auto pixels = [&](const FlipPicture& p) { return p.rgb + (row - at.reach) * p.row_floats - 3 * at.reach; };
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
      const size_t result = static_cast<size_t>(row) * static_cast<size_t>(in_lanes(width));
      run_lanes([&]<class V>() TRIAD_INLINE_BODY {
        filter_columns<V>(filters, centre, at.plane, step, at.columns, columns, at.stride);
        filter_columns<V>(filters, centre + 3 * at.plane, at.plane, step, at.columns, difference, at.stride);
      });
      run_lanes([&]<class V>() TRIAD_INLINE_BODY {
        judge<V>(filters, columns + at.pad, difference + at.pad, at.stride, width, stops, errors + result,
                 worst_stops ? worst_stops + result : nullptr);
      });
    }
  }
}

}  // namespace triad
