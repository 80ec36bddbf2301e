// SPDX-License-Identifier: Apache-2.0
// Samples at the points of a dyadic lattice, each taken once in the whole picture.
#pragma once

#include <cstdint>
#include <span>
#include <triad/sampling/pov_colour.hpp>
#include <vector>

namespace triad {

// Where a sample is, in units of 2^-bits of a pixel from the picture's upper left corner.
struct LatticePoint {
  int32_t x = 0, y = 0;
  bool operator==(const LatticePoint&) const = default;
};

// A sample belongs to the pixel that it lies in, on a border to the one to the right and below, at the picture's
// right and lower end to the last: that is where the film counts it. All pixels' corners are there from the start, in
// flat arrays; what lies between them takes 50 to 100 bytes a sample. Looking up from many threads is fine while
// nobody asks.
class Lattice {
 public:
  // With at least 1 bit, so that a pixel has a centre; the picture's sides << bits must be below 2^31. The centres
  // are kept like corners if with_centres.
  Lattice(SampleTaker& taker, int bits, bool with_centres, double gamma);

  int bits() const { return bits_; }
  int side() const { return 1 << bits_; }  // of a pixel, in units
  int width() const { return width_; }     // in pixels
  int height() const { return height_; }

  PovColour encode(const std::array<float, 3>& linear) const { return encode_(linear); }
  // Takes the samples at all corners, and the centres. False: the render was stopped.
  bool ask_corners();
  // Takes the samples at those points, none of them a corner or centre, that were not taken yet; the list may name a
  // point several times. Leaves in `points` those that were taken, in the same order. False: the render was stopped,
  // and some may be missing.
  bool ask(std::vector<LatticePoint>& points);

  // Frees what lies above that row of pixels, corners excepted; nothing there may be asked for or looked up again.
  void forget_above(int pixel_y);

  // The sample there, or null if none was taken.
  const PovColour* find(LatticePoint point) const;
  const PovColour& corner(int pixel_x, int pixel_y) const {
    return corners_[static_cast<size_t>(pixel_y) * static_cast<size_t>(width_ + 1) + static_cast<size_t>(pixel_x)];
  }
  // Whether samples were taken on the pixel's upper (left) border, between its corners; pixel_y (pixel_x) may be one
  // past the last.
  bool on_upper_border(int pixel_x, int pixel_y) const { return borders_[border(pixel_x, pixel_y)] & 1; }
  bool on_left_border(int pixel_x, int pixel_y) const { return borders_[border(pixel_x, pixel_y)] & 2; }

 private:
  static constexpr uint32_t kNone = UINT32_MAX;

  SampleRequest request(LatticePoint point) const;
  size_t border(int pixel_x, int pixel_y) const {
    return static_cast<size_t>(pixel_y) * static_cast<size_t>(width_ + 1) + static_cast<size_t>(pixel_x);
  }
  // The slot that has the point, or the empty one that it would have.
  size_t slot(LatticePoint point) const;
  void grow();

  SampleTaker& taker_;
  const int bits_, width_, height_;
  const PovEncoding encode_;
  std::vector<PovColour> corners_, centres_;
  std::vector<uint8_t> borders_;
  struct Slot {
    LatticePoint point;
    uint32_t index = kNone;
  };
  std::vector<Slot> slots_;  // open addressing, at most half full
  std::vector<PovColour> between_;
};

}  // namespace triad
