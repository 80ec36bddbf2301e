// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/colour/internal/transform_impl.hpp>
#include <vector>

namespace ocio = OCIO_NAMESPACE;

namespace triad {
namespace colour {
namespace {

bool same_for_rgb(const double (&v)[4]) { return v[0] == v[1] && v[0] == v[2]; }

bool add_matrix(const ocio::MatrixTransform& transform, Evaluator& into) {
  double m44[16], offset[4];
  transform.getMatrix(m44);
  transform.getOffset(offset);
  if (into.encode || m44[15] != 1) return false;
  for (int i = 0; i < 3; ++i)
    if (offset[i] != 0 || m44[i * 4 + 3] != 0 || m44[12 + i] != 0) return false;
  Matrix3 m;
  for (int i = 0; i < 9; ++i) m[i] = m44[i / 3 * 4 + i % 3];
  if (transform.getDirection() == ocio::TRANSFORM_DIR_INVERSE) m = inverse(m);
  into.matrix = multiply(m, into.matrix);
  into.has_matrix = true;
  return true;
}

bool add_curve(double gamma, double offset, bool decodes, Evaluator& into) {
  if (!(gamma > 1)) return false;
  auto curve = std::make_shared<const Curve>(gamma, offset);
  if (decodes) {
    if (into.decode || into.has_matrix || into.encode) return false;
    into.decode = std::move(curve);
  } else {
    if (into.encode) return false;
    into.encode = std::move(curve);
  }
  return true;
}

bool add(const ocio::ConstTransformRcPtr& transform, Evaluator& into) {
  const bool forward = transform->getDirection() == ocio::TRANSFORM_DIR_FORWARD;
  double gamma[4], offset[4] = {};
  if (const auto group = ocio::DynamicPtrCast<const ocio::GroupTransform>(transform)) {
    if (!forward) return false;
    for (int i = 0; i < group->getNumTransforms(); ++i)
      if (!add(group->getTransform(i), into)) return false;
    return true;
  }
  if (const auto matrix = ocio::DynamicPtrCast<const ocio::MatrixTransform>(transform))
    return add_matrix(*matrix, into);
  if (const auto curve = ocio::DynamicPtrCast<const ocio::ExponentWithLinearTransform>(transform)) {
    curve->getGamma(gamma);
    curve->getOffset(offset);
    if (!same_for_rgb(gamma) || !same_for_rgb(offset) || gamma[3] != 1 || !(offset[0] > 0) ||
        curve->getNegativeStyle() != ocio::NEGATIVE_MIRROR)
      return false;
    return add_curve(gamma[0], offset[0], forward, into);
  }
  if (const auto power = ocio::DynamicPtrCast<const ocio::ExponentTransform>(transform)) {
    power->getValue(gamma);
    if (!same_for_rgb(gamma) || gamma[3] != 1 || power->getNegativeStyle() != ocio::NEGATIVE_MIRROR) return false;
    return add_curve(gamma[0], 0, forward, into);
  }
  return false;
}

}  // namespace

std::optional<Evaluator> as_evaluator(const ocio::ConstProcessorRcPtr& processor) {
  Evaluator evaluator;
  if (!add(processor->createGroupTransform(), evaluator)) return std::nullopt;
  return evaluator;
}

void apply_processor(const ocio::CPUProcessor& processor, bool linear, float* pixels, size_t count, int channels,
                     int alpha) {
  constexpr size_t kChunk = 4096;  // pixels; 48 kB, which stays in the cache
  std::vector<float> rgb(std::min(count, kChunk) * 3);
  for (size_t begin = 0; begin < count; begin += kChunk) {
    const size_t n = std::min(kChunk, count - begin);
    float* const chunk = pixels + begin * static_cast<size_t>(channels);
    const auto coverage = [&](size_t i) {
      const float a = alpha >= 0 && !linear ? chunk[i * channels + alpha] : 1.f;
      return a == 0 ? 1.f : a;
    };
    for (size_t i = 0; i < n; ++i)
      for (int c = 0; c < 3; ++c) rgb[i * 3 + c] = chunk[i * channels + c] / coverage(i);
    ocio::PackedImageDesc picture(rgb.data(), static_cast<long>(n), 1, 3);
    processor.apply(picture);
    for (size_t i = 0; i < n; ++i)
      for (int c = 0; c < 3; ++c) chunk[i * channels + c] = rgb[i * 3 + c] * coverage(i);
  }
}

}  // namespace colour

bool ColourTransform::identity() const { return !impl_ || impl_->identity; }
const std::string& ColourTransform::from() const { return impl_->from; }
const std::string& ColourTransform::to() const { return impl_->to; }

void ColourTransform::apply(float* pixels, size_t count, int channels, int alpha) const {
  if (identity() || count == 0) return;
  if (impl_->own)
    impl_->own->apply(pixels, count, channels, alpha);
  else
    colour::apply_processor(*impl_->processor, impl_->linear, pixels, count, channels, alpha);
}

}  // namespace triad
