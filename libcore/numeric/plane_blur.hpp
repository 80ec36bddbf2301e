// SPDX-License-Identifier: Apache-2.0
// Multiplies the spectrum of a plane by a real transfer function that is even in both frequencies: what an eye,
// or any symmetric blur, does to a picture. Double precision, any size, on all threads of the process.
#pragma once

#include <complex>
#include <cstdint>
#include <functional>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/fft.hpp>

namespace triad {

// A torus of width x height samples. Immutable and thread-safe; each caller needs a Workspace of its own. The
// same values give the same bits for any number of threads.
class PlaneBlur {
 public:
  // Throws Error(kInput) for a side outside 1 .. 2^31 - 1.
  PlaneBlur(size_t width, size_t height);

  size_t width() const { return rows_.size(); }
  size_t height() const { return columns_.size(); }
  // What a Workspace holds; threads add a few rows and columns each.
  uint64_t workspace_bytes() const;

  // The plane's half spectrum. May be used again and again, for planes of the same size.
  class Workspace {
   public:
    explicit Workspace(const PlaneBlur& blur);

   private:
    friend class PlaneBlur;
    AlignedBuffer<std::complex<double>> spectrum_;
  };

  // Writes the samples of row y. Called once for each row, on several threads at once.
  using Fill = std::function<void(size_t y, double* row)>;
  // Writes the transfer at frequencies (nx, 0) .. (nx, height / 2), in cycles per width and height; nx <= width / 2.
  // Called once for each nx, on several threads at once.
  using Transfer = std::function<void(size_t nx, double* values)>;
  // Gets the blurred samples of row y, which it may use as it likes, on several threads at once.
  using Take = std::function<void(size_t y, double* row)>;

  // The same transfer, with its values kept where the plane is a single row: rows of one length follow each other by
  // the thousand, planes do not. Copies what it needs.
  Transfer remembered(const Transfer& transfer) const;

  // Rows 0 .. rows - 1 of the result go to `take`; the others are not made.
  void apply(const Fill& fill, const Transfer& transfer, size_t rows, const Take& take, Workspace& workspace) const;

 private:
  void blur_columns(size_t first, size_t last, const Transfer& transfer, Workspace& workspace) const;

  RealFft<double> rows_, columns_;
};

}  // namespace triad
