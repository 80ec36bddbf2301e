// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <triad/base/error.hpp>
#include <triad/numeric/polyphase.hpp>
#include <type_traits>

#include "polyphase_plan.inc"

namespace triad {
namespace {

using polyphase::kCacheLine;
using polyphase::Plan;
using polyphase::Segment;

// Sequential float sums of more terms than this lose digits to sheer length: a sum of n equal terms can be off
// by n/4 units in the last place.
constexpr size_t kMostStepsInASum = 64;
constexpr int kFarthestCell = 1 << 24;

struct Step {
  unsigned outputs;  // bit e: output e has a coefficient
  int plane;
  int shift_px;
  double coefficients[3];
};

void check_kernel(const FirKernel& kernel) {
  const auto taps = kernel.coefficients.size() / 3;
  if (kernel.coefficients.size() % 3 != 0)
    throw_internal("a kernel of " + std::to_string(kernel.coefficients.size()) +
                   " coefficients; there must be three for each tap");
  if (std::abs(static_cast<double>(kernel.first_cell)) > kFarthestCell || taps > kFarthestCell)
    throw_internal("a kernel of " + std::to_string(taps) + " taps from cell " + std::to_string(kernel.first_cell) +
                   "; it must lie within 2^24 cells of the pixel");
}

// The terms of all outputs, each (cell, channel) once, in the order of summation.
template <typename Real>
std::vector<Step> make_steps(int cells, int first_cell, int window_cells, const std::array<FirKernel, 3>& kernels) {
  std::vector<Step> steps;
  for (int cell = 0; cell < window_cells; ++cell) {
    for (int d = 0; d < 3; ++d) {
      Step step{0, 3 * (cell % cells) + d, cell / cells, {}};
      for (unsigned e = 0; e < 3; ++e) {
        const int64_t index = 3 * (int64_t{first_cell} + cell - kernels[e].first_cell) + d;
        if (index < 0 || index >= std::ssize(kernels[e].coefficients)) continue;
        const Real coefficient = static_cast<Real>(kernels[e].coefficients[static_cast<size_t>(index)]);
        if (!std::isfinite(coefficient)) throw_internal("a kernel with a coefficient that is not finite");
        step.coefficients[e] = coefficient;
        if (coefficient != 0) step.outputs |= 1u << e;
      }
      if (step.outputs != 0) steps.push_back(step);
    }
  }
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) {
    const int more = std::popcount(a.outputs) - std::popcount(b.outputs);
    return more != 0 ? more > 0 : a.outputs < b.outputs;
  });
  return steps;
}

}  // namespace

void* PolyphaseScratch::reserve(size_t bytes) {
  if (storage_.size() < bytes + kCacheLine) storage_.assign(bytes + kCacheLine, std::byte{0});
  const auto address = reinterpret_cast<uintptr_t>(storage_.data());
  return storage_.data() + (kCacheLine - address % kCacheLine) % kCacheLine;
}

template <typename Real>
struct PolyphaseFir<Real>::State {
  Plan<Real> plan{};
  void (*apply_row)(const Plan<Real>&, const Real*, Real*, int, Real*) = nullptr;
  std::vector<Segment> segments;
  std::vector<int32_t> offsets;
  std::vector<Real> coefficients;

  State(int cells, const std::array<FirKernel, 3>& kernels, CpuPath path) {
    choose_path(path);
    if (cells < 1 || cells > 8)
      throw_internal("a polyphase filter of " + std::to_string(cells) + " cells a pixel; there can be 1 to 8");
    int first = std::numeric_limits<int>::max(), past = std::numeric_limits<int>::min();
    for (const FirKernel& kernel : kernels) {
      check_kernel(kernel);
      if (kernel.coefficients.empty()) continue;
      first = std::min(first, kernel.first_cell);
      past = std::max(past, kernel.first_cell + static_cast<int>(kernel.coefficients.size() / 3));
    }
    plan.cells = cells;
    plan.first_cell = first < past ? first : 0;
    plan.window_cells = first < past ? past - first : 0;
    const size_t halo = static_cast<size_t>(plan.window_cells / cells);
    // An odd number of cache lines, so that equal places of different planes never compete for one cache set.
    const size_t line = kCacheLine / sizeof(Real);
    plan.plane_stride = ((polyphase::kBlockPx + halo + polyphase::kPlanePad + line - 1) / line | 1) * line;
    fill(make_steps<Real>(cells, plan.first_cell, plan.window_cells, kernels));
    plan.segments = segments.data();
    plan.n_segments = static_cast<int>(segments.size());
    plan.offsets = offsets.data();
    plan.coefficients = coefficients.data();
  }

  void choose_path([[maybe_unused]] CpuPath path) {
    apply_row = polyphase::apply_row_baseline;
    if (!cpu_can_run(path)) throw_internal(std::string("this machine cannot run the path ") + cpu_path_name(path));
#if defined(__x86_64__)
    if constexpr (std::is_same_v<Real, float>) {
      if (path == CpuPath::kAvx2) apply_row = polyphase::apply_row_avx2;
      if (path == CpuPath::kAvx512) apply_row = polyphase::apply_row_avx512;
    }
#endif
  }

  // Cuts the steps into sums of nearly equal length, and these into segments with the same outputs.
  void fill(const std::vector<Step>& steps) {
    const size_t sums = (steps.size() + kMostStepsInASum - 1) / kMostStepsInASum;
    for (size_t i = 0, begin = 0; i < sums; ++i) {
      const size_t sum_end = steps.size() * (i + 1) / sums;
      while (begin < sum_end) {
        size_t end = begin;
        while (end < sum_end && steps[end].outputs == steps[begin].outputs) ++end;
        add_segment(steps, begin, end, end == sum_end);
        begin = end;
      }
    }
  }

  void add_segment(const std::vector<Step>& steps, size_t begin, size_t end, bool ends_sum) {
    segments.push_back({static_cast<int>(steps[begin].outputs), static_cast<int>(begin),
                        static_cast<int>(coefficients.size()), static_cast<int>(end - begin), ends_sum});
    for (size_t i = begin; i < end; ++i) {
      offsets.push_back(static_cast<int32_t>(static_cast<size_t>(steps[i].plane) * plan.plane_stride) +
                        steps[i].shift_px);
      for (unsigned e = 0; e < 3; ++e)
        if (steps[i].outputs >> e & 1) coefficients.push_back(static_cast<Real>(steps[i].coefficients[e]));
    }
  }
};

template <typename Real>
PolyphaseFir<Real>::PolyphaseFir(int cells, const std::array<FirKernel, 3>& kernels, CpuPath path)
    : state_(std::make_unique<const State>(cells, kernels, path)) {}
template <typename Real>
PolyphaseFir<Real>::~PolyphaseFir() = default;
template <typename Real>
PolyphaseFir<Real>::PolyphaseFir(PolyphaseFir&&) noexcept = default;
template <typename Real>
PolyphaseFir<Real>& PolyphaseFir<Real>::operator=(PolyphaseFir&&) noexcept = default;

template <typename Real>
int PolyphaseFir<Real>::cells() const {
  return state_->plan.cells;
}
template <typename Real>
int PolyphaseFir<Real>::first_cell() const {
  return state_->plan.first_cell;
}
template <typename Real>
int PolyphaseFir<Real>::last_cell() const {
  return state_->plan.first_cell + state_->plan.window_cells - 1;
}

template <typename Real>
void PolyphaseFir<Real>::apply_row(const Real* in, Real* out, int n_pixels, PolyphaseScratch& scratch) const {
  auto* memory = static_cast<Real*>(scratch.reserve(state_->plan.scratch_values() * sizeof(Real)));
  state_->apply_row(state_->plan, in, out, n_pixels, memory);
}

template class PolyphaseFir<float>;
template class PolyphaseFir<double>;

}  // namespace triad
