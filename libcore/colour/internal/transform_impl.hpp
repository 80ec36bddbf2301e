// SPDX-License-Identifier: Apache-2.0
// OpenColorIO behind ColourTransform. Not installed.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <optional>
#include <string>
#include <triad/colour/colour.hpp>
#include <triad/colour/internal/evaluator.hpp>

namespace triad {

struct ColourTransform::Impl {
  std::string from, to;
  bool identity = false;
  bool linear = false;                               // proportional to its input, so alpha need not be divided out
  std::optional<colour::Evaluator> own;              // when the transform is of that kind
  OCIO_NAMESPACE::ConstCPUProcessorRcPtr processor;  // otherwise
};

namespace colour {

// The processor as curve, matrix and curve, or nothing when it is more than that.
std::optional<Evaluator> as_evaluator(const OCIO_NAMESPACE::ConstProcessorRcPtr& processor);

// Applies the processor to `count` pixels of `channels` floats as ColourTransform::apply documents it.
void apply_processor(const OCIO_NAMESPACE::CPUProcessor& processor, bool linear, float* pixels, size_t count,
                     int channels, int alpha);

}  // namespace colour
}  // namespace triad
