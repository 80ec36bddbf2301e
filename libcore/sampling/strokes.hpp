// SPDX-License-Identifier: Apache-2.0
// Test pictures made of strokes: what subpixel filters are for, without a scene or a file.
#pragma once

#include <memory>
#include <string>
#include <triad/image/image.hpp>
#include <triad/sampling/analytic.hpp>
#include <vector>

namespace triad {

// A straight bar from (x0, y0) to (x1, y1), ends cut at right angles; in display pixels.
struct Stroke {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double width_px = 1;
  Rgb colour{1, 1, 1};
};

// Strokes over a background, later ones over earlier ones: deterministic, sharp edges.
class StrokesSource final : public Source {
 public:
  // The film has width_px * cells.x by height_px * cells.y pixels; strokes lie where they lie whatever the cells.
  // Sizes are at least 1, and the film's sides below 2^31.
  StrokesSource(int width_px, int height_px, const Cells& cells, const Rgb& background, std::vector<Stroke> strokes);
  int width() const override { return width_; }
  int height() const override { return height_; }
  SourceAbilities abilities() const override { return {.deterministic = true}; }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override;

 private:
  Rgb at(double x_px, double y_px) const;

  int width_, height_, columns_, rows_;
  Cells cells_;
  Rgb background_;
  std::vector<Stroke> strokes_;
  std::vector<std::vector<int>> buckets_;  // of squares of the picture: the strokes that may reach into them
};

// The pictures, as make_strokes() knows them: "strokes", "colours", "stems".
const std::vector<std::string>& stroke_picture_names();

// `name` one of
//   strokes  white strokes at random angles on black, .5 to 2 pixels wide, about a seventh of the ground
//   colours  the same strokes, each in a random colour of the whole gamut
//   stems    black on white, upright and level stems of about a pixel in lines, as letters are made of
// The same for the same name, size and seed. Throws Error(kUsage) for any other name.
std::unique_ptr<Source> make_strokes(const std::string& name, int width_px, int height_px, const Cells& cells,
                                     uint64_t seed = 0);

}  // namespace triad
