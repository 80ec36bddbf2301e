// SPDX-License-Identifier: Apache-2.0
// The two ways to apply a linear filter to a row, for platt.
#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <triad/display/row_filter.hpp>
#include <triad/numeric/polyphase.hpp>
#include <type_traits>
#include <vector>

namespace platt_engines {

// Working memory that threads take and give back, so that a strip of one row costs no allocation.
template <class T>
class Pool {
 public:
  std::unique_ptr<T> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return nullptr;
    std::unique_ptr<T> out = std::move(free_.back());
    free_.pop_back();
    return out;
  }
  void give(std::unique_ptr<T> item) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(item));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

// Turns cells into drives. Pixel 0 reads the cells first_cell() .. last_cell(), unless whole_rows().
class Engine {
 public:
  virtual ~Engine() = default;
  virtual bool whole_rows() const = 0;
  virtual int first_cell() const = 0;
  virtual int last_cell() const = 0;
  // cells: the cell 0 of pixel x0, or of the row for whole_rows(). Writes pixels x0 .. x1 - 1.
  virtual void row(const float* cells, int x0, int x1, float* out) = 0;
};

template <class Real>
class FftEngine : public Engine {
 public:
  FftEngine(const triad::FilterDesign& design, int width_px, triad::Edge edge) : filter_(design, width_px, edge) {}
  bool whole_rows() const override { return true; }
  int first_cell() const override { return 0; }
  int last_cell() const override { return 0; }
  void row(const float* cells, int x0, int x1, float* out) override {
    auto work = pool_.take();
    if (!work) work = std::make_unique<Work>(filter_);
    filter_.apply(cells, work->drives.data(), work->workspace);
    std::copy(work->drives.data() + 3 * static_cast<ptrdiff_t>(x0),
              work->drives.data() + 3 * static_cast<ptrdiff_t>(x1), out);
    pool_.give(std::move(work));
  }

 private:
  struct Work {
    explicit Work(const triad::RowFilter<Real>& filter)
        : workspace(filter), drives(3 * static_cast<size_t>(filter.width_px())) {}
    typename triad::RowFilter<Real>::Workspace workspace;
    std::vector<float> drives;
  };
  triad::RowFilter<Real> filter_;
  Pool<Work> pool_;
};

template <class Real>
class FirEngine : public Engine {
 public:
  FirEngine(int cells, const std::array<triad::FirKernel, 3>& kernels) : filter_(cells, kernels) {}
  bool whole_rows() const override { return false; }
  int first_cell() const override { return filter_.first_cell(); }
  int last_cell() const override { return filter_.last_cell(); }
  void row(const float* cells, int x0, int x1, float* out) override {
    auto work = pool_.take();
    if (!work) work = std::make_unique<Work>();
    const int pixels = x1 - x0;
    if constexpr (std::is_same_v<Real, float>) {
      filter_.apply_row(cells, out, pixels, work->scratch);
    } else {
      const ptrdiff_t first = 3 * static_cast<ptrdiff_t>(first_cell());
      const ptrdiff_t end = 3 * (static_cast<ptrdiff_t>(filter_.cells()) * (pixels - 1) + last_cell() + 1);
      work->in.assign(cells + first, cells + end);
      work->out.resize(3 * static_cast<size_t>(pixels));
      filter_.apply_row(work->in.data() - first, work->out.data(), pixels, work->scratch);
      for (const double value : work->out) *out++ = static_cast<float>(value);
    }
    pool_.give(std::move(work));
  }

 private:
  struct Work {
    triad::PolyphaseScratch scratch;
    std::vector<double> in, out;
  };
  triad::PolyphaseFir<Real> filter_;
  Pool<Work> pool_;
};

}  // namespace platt_engines
