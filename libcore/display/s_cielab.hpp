// SPDX-License-Identifier: Apache-2.0
// S-CIELAB: the colour difference of two pictures after both were blurred as an eye at a distance does. Zhang and
// Wandell, "A spatial extension of CIELAB for digital color image reproduction" (SID Journal 5(1), 1997), with all
// three Gaussians of the luminance kernel, by FFT.
#pragma once

#include <array>
#include <cstdint>
#include <triad/display/light.hpp>
#include <triad/numeric/plane_blur.hpp>
#include <vector>

namespace triad {

// A torus of width x height cells, of which the first columns x rows are compared. Immutable and thread-safe; the
// same pictures give the same bits for any number of threads.
class SCielab {
 public:
  struct Shape {
    size_t width = 1, height = 1;  // of the torus, in cells
    size_t columns = 1, rows = 1;  // of the part that counts; at most width and height
    double cells_per_degree_x = 1, cells_per_degree_y = 1;
  };
  // rgb_to_xyz: of linear light, row-major; its white (1, 1, 1) is CIELAB's. Throws Error(kInput) for a side that
  // PlaneBlur refuses.
  SCielab(const std::array<double, 9>& rgb_to_xyz, const Shape& shape);

  // What one comparison holds in memory.
  uint64_t workspace_bytes() const;

  // Reuse one for pictures of the same shape; each thread that compares needs its own.
  class Workspace {
   public:
    explicit Workspace(const SCielab& metric);

   private:
    friend class SCielab;
    PlaneBlur::Workspace blur_;
    std::vector<float> seen_[2][3];  // [picture][opponent channel]: a step of float is 1e-5 of a Delta E
  };

  // out(y, values) for each row that counts: `columns` values of Delta E*ab (CIE76), on several threads at once.
  void delta_e(const Light& test, const Light& reference, const RowSink& out, Workspace& workspace) const;

 private:
  Shape shape_;
  PlaneBlur blur_;
  std::array<double, 9> rgb_to_opponent_, opponent_to_xyz_;
  std::array<double, 3> white_;
  PlaneBlur::Transfer transfer_[3];
};

}  // namespace triad
