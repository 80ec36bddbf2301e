// SPDX-License-Identifier: Apache-2.0
// FLIP as its papers write it down: every filter a sum over a square, everything in double precision.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace flip_reference {

using Rgb = std::array<double, 3>;
struct Picture {
  int width = 0, height = 0;
  std::vector<Rgb> pixels;             // linear light
  const Rgb& at(int x, int y) const {  // the border repeated
    return pixels[static_cast<size_t>(std::clamp(y, 0, height - 1)) * static_cast<size_t>(width) +
                  static_cast<size_t>(std::clamp(x, 0, width - 1))];
  }
};

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr Rgb kWhite{.950428545, 1, 1.088900371};  // XYZ

inline double decoded(double code) { return code <= .04045 ? code / 12.92 : std::pow((code + .055) / 1.055, 2.4); }

inline Rgb xyz(const Rgb& c) {
  return {(10135552 * c[0] + 8788810 * c[1] + 4435075 * c[2]) / 24577794,
          (2613072 * c[0] + 8788810 * c[1] + 887015 * c[2]) / 12288897,
          (1425312 * c[0] + 8788810 * c[1] + 70074185 * c[2]) / 73733382};
}
inline Rgb rgb(const Rgb& v) {
  return {3.241003275 * v[0] - 1.537398934 * v[1] - .498615861 * v[2],
          -.969224334 * v[0] + 1.875930071 * v[1] + .041554224 * v[2],
          .055639423 * v[0] - .204011202 * v[1] + 1.057148933 * v[2]};
}
inline Rgb ycxcz(const Rgb& c) {
  const Rgb v = xyz(c);
  const double x = v[0] / kWhite[0], y = v[1], z = v[2] / kWhite[2];
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}
inline Rgb xyz_of_ycxcz(const Rgb& o) {
  const double y = (o[0] + 16) / 116;
  return {(y + o[1] / 500) * kWhite[0], y, (y - o[2] / 200) * kWhite[2]};
}
inline Rgb hunt_lab(const Rgb& c) {
  const auto f = [](double t) {
    const double delta = 6. / 29;
    return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4. / 29;
  };
  const Rgb v = xyz(c);
  const double x = f(v[0] / kWhite[0]), y = f(v[1]), z = f(v[2] / kWhite[2]);
  const double lightness = 116 * y - 16;
  return {lightness, .01 * lightness * 500 * (x - y), .01 * lightness * 200 * (y - z)};
}
inline double hyab(const Rgb& a, const Rgb& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// A square of weights, row by row.
struct Kernel {
  int radius;
  std::vector<double> weights;
  Kernel(int r, const std::function<double(int, int)>& f) : radius(r) {
    for (int y = -r; y <= r; ++y)
      for (int x = -r; x <= r; ++x) weights.push_back(f(x, y));
  }
  // So that negative weights sum to -1, if there are any, and positive ones to 1.
  Kernel normalised() && {
    double negative = 0, positive = 0;
    for (const double w : weights) (w > 0 ? positive : negative) += std::abs(w);
    for (double& w : weights) w /= w > 0 ? positive : negative > 0 ? negative : 1;
    return std::move(*this);
  }
  double apply(const std::function<double(int, int)>& picture, int px, int py) const {
    double sum = 0;
    size_t i = 0;
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) sum += weights[i++] * picture(px + x, py + y);
    return sum;
  }
};

inline int sensitivity_radius(double ppd) {
  return static_cast<int>(std::ceil(3 * std::sqrt(.04 / (2 * kPi * kPi)) * ppd));
}
inline Kernel sensitivity(double ppd, double a1, double b1, double a2 = 0, double b2 = 1) {
  return Kernel(sensitivity_radius(ppd),
                [=](int x, int y) {
                  const double d2 = (x * x + y * y) / (ppd * ppd);
                  const auto term = [&](double a, double b) {
                    return a * std::sqrt(kPi / b) * std::exp(-kPi * kPi * d2 / b);
                  };
                  return term(a1, b1) + term(a2, b2);
                })
      .normalised();
}

// Errors of a picture of linear light in [0, 1].
inline std::vector<double> ldr(const Picture& reference, const Picture& test, double ppd) {
  const Kernel kernels[] = {sensitivity(ppd, 1, .0047), sensitivity(ppd, 1, .0053),
                            sensitivity(ppd, 34.1, .04, 13.5, .025)};
  const double deviation = .5 * .082 * ppd;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  const auto gauss = [=](int x, int y) { return std::exp(-(x * x + y * y) / (2 * deviation * deviation)); };
  const auto bend = [=](int x) { return x * x / (deviation * deviation) - 1; };
  const Kernel features[] = {Kernel(radius, [&](int x, int y) { return -x * gauss(x, y); }).normalised(),
                             Kernel(radius, [&](int x, int y) { return -y * gauss(x, y); }).normalised(),
                             Kernel(radius, [&](int x, int y) { return bend(x) * gauss(x, y); }).normalised(),
                             Kernel(radius, [&](int x, int y) { return bend(y) * gauss(x, y); }).normalised()};
  const double most = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), .7), limit = .4 * most;

  std::vector<double> errors;
  for (int y = 0; y < reference.height; ++y)
    for (int x = 0; x < reference.width; ++x) {
      Rgb lab[2];
      double edge[2], point[2];
      for (size_t i = 0; i < 2; ++i) {
        const Picture& picture = i == 0 ? reference : test;
        Rgb opponent;
        for (size_t c = 0; c < 3; ++c)
          opponent[c] = kernels[c].apply([&](int px, int py) { return ycxcz(picture.at(px, py))[c]; }, x, y);
        Rgb seen = rgb(xyz_of_ycxcz(opponent));
        for (double& v : seen) v = std::clamp(v, 0., 1.);
        lab[i] = hunt_lab(seen);
        const auto light = [&](int px, int py) { return (ycxcz(picture.at(px, py))[0] + 16) / 116; };
        double found[4];
        for (size_t k = 0; k < 4; ++k) found[k] = features[k].apply(light, x, y);
        edge[i] = std::hypot(found[0], found[1]);
        point[i] = std::hypot(found[2], found[3]);
      }
      double colour = std::pow(hyab(lab[0], lab[1]), .7);
      colour = colour < limit ? colour * .95 / limit : .95 + (colour - limit) / (most - limit) * .05;
      const double feature =
          std::sqrt(std::max(std::abs(edge[0] - edge[1]), std::abs(point[0] - point[1])) / std::sqrt(2.));
      errors.push_back(std::pow(colour, 1 - feature));
    }
  return errors;
}

enum class ToneMapper { kAces, kReinhard, kHable };
inline Rgb toned(ToneMapper mapper, const Rgb& c) {
  Rgb out;
  for (size_t i = 0; i < 3; ++i) {
    const double v = c[i];
    if (mapper == ToneMapper::kReinhard)
      out[i] = v / (1 + .2126 * c[0] + .7152 * c[1] + .0722 * c[2]);
    else if (mapper == ToneMapper::kHable)
      out[i] = (.231683 * v * v + .013791 * v) / (.18 * v * v + .3 * v + .018);
    else  // .6 v in (2.51 w^2 + .03 w) / (2.43 w^2 + .59 w + .14)
      out[i] = (2.51 * .36 * v * v + .03 * .6 * v) / (2.43 * .36 * v * v + .59 * .6 * v + .14);
  }
  return out;
}

struct Hdr {
  std::vector<double> errors, stops;
};
inline Picture shown(const Picture& picture, ToneMapper mapper, double stops) {
  Picture out = picture;
  for (Rgb& c : out.pixels) {
    for (double& v : c) v *= std::exp2(stops);
    c = toned(mapper, c);
    for (double& v : c) v = std::clamp(v, 0., 1.);
  }
  return out;
}
inline Hdr hdr(const Picture& reference, const Picture& test, double ppd, ToneMapper mapper,
               const std::vector<float>& exposures) {
  Hdr out;
  for (const float f : exposures) {
    const auto stops = static_cast<double>(f);
    const std::vector<double> errors = ldr(shown(reference, mapper, stops), shown(test, mapper, stops), ppd);
    if (out.errors.empty()) {
      out.errors.assign(errors.size(), 0);
      out.stops.assign(errors.size(), stops);
    }
    for (size_t i = 0; i < errors.size(); ++i)
      if (errors[i] > out.errors[i]) {
        out.errors[i] = errors[i];
        out.stops[i] = stops;
      }
  }
  return out;
}

}  // namespace flip_reference
