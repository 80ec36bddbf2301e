// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <cstdint>
#include <triad/colour/internal/evaluator.hpp>

namespace triad::colour {

PowerTable::PowerTable(double p) : p_(p) {
  for (int i = 0; i < kIntervals; ++i) {
    const double middle = 1 + (i + .5) / kIntervals;
    const double value = std::pow(middle, p);
    // Taylor's series about the middle.
    cubic_[i] = {value, value * p / middle, value * p * (p - 1) / (2 * middle * middle),
                 value * p * (p - 1) * (p - 2) / (6 * middle * middle * middle)};
  }
  for (int e = 0; e < kExponents; ++e) scale_[e] = std::exp2((e + kLeastExponent) * p);
}

double PowerTable::operator()(double x) const {
  const auto bits = std::bit_cast<uint64_t>(x);
  const int64_t exponent = static_cast<int64_t>(bits >> 52) - (1023 + kLeastExponent);
  if (exponent < 0 || exponent >= kExponents) return std::pow(x, p_);  // also infinite and not-a-number
  const auto interval = static_cast<size_t>(bits >> 46 & (kIntervals - 1));
  const double mantissa = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
  const double t = mantissa - (1 + (static_cast<double>(interval) + .5) / kIntervals);
  const auto& c = cubic_[interval];
  return (c[0] + t * (c[1] + t * (c[2] + t * c[3]))) * scale_[static_cast<size_t>(exponent)];
}

Curve::Curve(double gamma, double offset) : gamma_(gamma), offset_(offset), up_(gamma), down_(1 / gamma) {
  if (gamma == 2.4 && offset == .055) {  // IEC 61966-2-1
    slope_ = 12.92;
    encoded_break_ = .04045;
    linear_break_ = .0031308;
  } else if (offset > 0) {
    encoded_break_ = offset / (gamma - 1);
    linear_break_ = std::pow(offset * gamma / ((gamma - 1) * (1 + offset)), gamma);
    slope_ = encoded_break_ / linear_break_;
  }
}

double Curve::decode(double v) const {
  const double a = std::abs(v);
  const double result = a <= encoded_break_ ? a / slope_ : up_((a + offset_) / (1 + offset_));
  return std::copysign(result, v);
}

double Curve::encode(double v) const {
  const double a = std::abs(v);
  const double result = a <= linear_break_ ? a * slope_ : (1 + offset_) * down_(a) - offset_;
  return std::copysign(result, v);
}

bool Evaluator::simplify() {
  constexpr double kNothing = 1e-9;  // a tenth of what float can tell from 1
  bool unit = true;
  for (int i = 0; i < 9; ++i) unit = unit && std::abs(matrix[i] - (i % 4 == 0)) < kNothing;
  has_matrix = !unit;
  if (unit && decode && encode && decode->same_as(*encode)) {
    decode.reset();
    encode.reset();
  }
  return !has_matrix && !decode && !encode;
}

std::array<double, 3> Evaluator::operator()(std::array<double, 3> rgb) const {
  if (decode)
    for (double& v : rgb) v = decode->decode(v);
  if (has_matrix) rgb = multiply(matrix, rgb);
  if (encode)
    for (double& v : rgb) v = encode->encode(v);
  return rgb;
}

void Evaluator::apply(float* pixels, size_t count, int channels, int alpha) const {
  const bool divide = alpha >= 0 && !linear();
  for (size_t i = 0; i < count; ++i, pixels += channels) {
    const double a = divide && pixels[alpha] != 0 ? static_cast<double>(pixels[alpha]) : 1.;
    const auto rgb = (*this)({pixels[0] / a, pixels[1] / a, pixels[2] / a});
    for (int c = 0; c < 3; ++c) pixels[c] = static_cast<float>(rgb[c] * a);
  }
}

}  // namespace triad::colour
