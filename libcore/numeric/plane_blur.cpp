// SPDX-License-Identifier: Apache-2.0
// Rows are transformed first. A transfer that is even in the vertical frequency is a real convolution of the
// columns, and so acts on their real and imaginary parts one by one: each is a real transform there and back, and
// one spectrum of the rows is all that is ever stored.
#include <algorithm>
#include <triad/base/parallel.hpp>
#include <triad/numeric/plane_blur.hpp>
#include <vector>

namespace triad {
namespace {

constexpr size_t kRowsAtOnce = 16;
constexpr size_t kColumnsAtOnce = 8;  // complex numbers: two cache lines of each row

}  // namespace

PlaneBlur::PlaneBlur(size_t width, size_t height) : rows_(width), columns_(height) {}

uint64_t PlaneBlur::workspace_bytes() const {
  return uint64_t{rows_.spectrum_size()} * columns_.size() * sizeof(std::complex<double>);
}

PlaneBlur::Workspace::Workspace(const PlaneBlur& blur) : spectrum_(blur.rows_.spectrum_size() * blur.height()) {}

PlaneBlur::Transfer PlaneBlur::remembered(const Transfer& transfer) const {
  if (height() > 1) return transfer;
  std::vector<double> values(rows_.spectrum_size());
  for (size_t nx = 0; nx < values.size(); ++nx) transfer(nx, &values[nx]);
  return [values](size_t nx, double* value) { *value = values[nx]; };
}

void PlaneBlur::apply(const Fill& fill, const Transfer& transfer, size_t rows, const Take& take,
                      Workspace& work) const {
  const size_t stride = rows_.spectrum_size();
  const auto for_rows = [&](size_t count, const auto& body) {
    parallel_for(static_cast<int64_t>((count + kRowsAtOnce - 1) / kRowsAtOnce), [&](int64_t block) {
      AlignedBuffer<double> row(width());
      AlignedBuffer<std::complex<double>> spectrum(stride);
      const size_t first = static_cast<size_t>(block) * kRowsAtOnce;
      for (size_t y = first; y < std::min(count, first + kRowsAtOnce); ++y)
        body(y, row.data(), spectrum.data(), &work.spectrum_[y * stride]);
    });
  };
  for_rows(height(), [&](size_t y, double* row, std::complex<double>* spectrum, std::complex<double>* stored) {
    fill(y, row);
    rows_.forward(row, spectrum);
    std::copy_n(spectrum, stride, stored);
  });
  if (height() == 1) {
    const double scale = 1 / static_cast<double>(width());
    for (size_t nx = 0; nx < stride; ++nx) {
      double value;
      transfer(nx, &value);
      work.spectrum_[nx] *= value * scale;
    }
  } else {
    parallel_for(static_cast<int64_t>((stride + kColumnsAtOnce - 1) / kColumnsAtOnce), [&](int64_t block) {
      const size_t first = static_cast<size_t>(block) * kColumnsAtOnce;
      blur_columns(first, std::min(stride, first + kColumnsAtOnce), transfer, work);
    });
  }
  for_rows(rows, [&](size_t y, double* row, std::complex<double>* spectrum, std::complex<double>* stored) {
    std::copy_n(stored, stride, spectrum);
    rows_.inverse(spectrum, row);
    take(y, row);
  });
}

void PlaneBlur::blur_columns(size_t first, size_t last, const Transfer& transfer, Workspace& work) const {
  const size_t stride = rows_.spectrum_size(), height = columns_.size();
  const double scale = 1 / (static_cast<double>(width()) * static_cast<double>(height));
  AlignedBuffer<double> values(columns_.spectrum_size());
  // Real and imaginary parts of the columns, each on a cache line of its own.
  const size_t pitch = (height + 7) / 8 * 8, parts = 2 * (last - first);
  AlignedBuffer<double> columns(parts * pitch);
  AlignedBuffer<std::complex<double>> spectrum(columns_.spectrum_size());
  for (size_t y = 0; y < height; ++y)
    for (size_t i = 0; i < last - first; ++i) {
      const std::complex<double> v = work.spectrum_[y * stride + first + i];
      columns[2 * i * pitch + y] = v.real();
      columns[(2 * i + 1) * pitch + y] = v.imag();
    }
  for (size_t i = 0; i < parts; ++i) {
    if (i % 2 == 0) transfer(first + i / 2, values.data());
    columns_.forward(&columns[i * pitch], spectrum.data());
    for (size_t ny = 0; ny < spectrum.size(); ++ny) spectrum[ny] *= values[ny] * scale;
    columns_.inverse(spectrum.data(), &columns[i * pitch]);
  }
  for (size_t y = 0; y < height; ++y)
    for (size_t i = 0; i < last - first; ++i)
      work.spectrum_[y * stride + first + i] = {columns[2 * i * pitch + y], columns[(2 * i + 1) * pitch + y]};
}

}  // namespace triad
