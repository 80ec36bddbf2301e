// SPDX-License-Identifier: Apache-2.0
// Where a picture's samples lie and how they become pixels. A strategy asks a source, and returns the picture
// with what it cost; it never talks to a scene.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <triad/sampling/film.hpp>
#include <triad/sampling/source.hpp>
#include <vector>

namespace triad {

// A parameter of a strategy: a number, whole unless `decimals`, or one of several words.
struct StrategyParam {
  std::string name, doc;
  double least = 0, most = 0, usual = 0;  // most may be infinite where there are decimals
  bool decimals = false;
  std::vector<std::string> choices{};  // not empty: the value is the place of one of these, from 0
};
// A parameter that is one of several words, the first by default.
inline StrategyParam choice_param(std::string name, std::string doc, std::vector<std::string> choices) {
  const double last = static_cast<double>(choices.size()) - 1;
  return {std::move(name), std::move(doc), 0, last, 0, false, std::move(choices)};
}
// A value of it as text: "16", "0.01", "inf", "lanczos2".
std::string strategy_value(const StrategyParam& param, double value);

struct StrategyInfo {
  std::string name, summary;  // the summary is one line
  std::string doc;            // what it does, when to take it
  std::vector<StrategyParam> params;
};

struct RenderOptions {
  uint64_t seed = 0;
  Cells cells;       // the film's pixels are cells, so many of them in a display pixel; for strategies that see both
  int tile_px = 32;  // side of the squares that threads take; never changes the picture
  // How long a render may take several samples of some pixels before every pixel has one, for those who look at what
  // it has when it is ended early. It never changes a picture that is complete.
  double soon_s = 2;
  FilmPlanes planes;
  double until_rmse = 0;       // stop after the pass in which Film::estimated_rmse() is at most this; 0: all samples
  std::function<bool()> stop;  // asked every few thousand samples, by any thread; true ends the render early
  std::function<void(double)> progress;  // told the share that is done, 0..1; one call at a time, by any thread
};

struct PassRecord {
  uint64_t samples = 0;  // of this pass
  double seconds = 0;
  double rmse =
      std::numeric_limits<double>::quiet_NaN();  // estimated after it; always after the last, if planes.error
};

struct RenderResult {
  Film film;  // each sample in the pixel it was taken for: counts, geometry, and for most strategies the colours
  std::vector<std::array<double, 3>> colour{};  // not empty: the picture, in place of the film's means
  // Of planes.reasons, in the order of Strategy::reason_channels(), each row by row.
  std::vector<std::vector<float>> reasons{};
  std::vector<PassRecord> passes;
  uint64_t samples = 0;                // taken, as CountingSource counted them
  uint64_t dropped = 0;                // of these, not valid or not finite, and left out
  int dropped_x = -1, dropped_y = -1;  // the first pixel, in reading order, that lost one; -1: none did
  bool complete = true;                // false: stop() said so before the end
  bool reached = false;                // until_rmse was reached

  // The picture's colour there.
  std::array<double, 3> mean(size_t pixel) const { return colour.empty() ? film.mean(pixel) : colour[pixel]; }
  // Film::image() with these colours, then the reasons, whose channels' names are given.
  Image image(const std::vector<std::string>& reason_channels = {}) const;
};

// A strategy with its parameters. Immutable; render() may be called from several threads.
class Strategy {
 public:
  virtual ~Strategy() = default;
  virtual const StrategyInfo& info() const = 0;
  // "sobol-owen:spp=16": every parameter, as make_strategy() reads it.
  virtual std::string text() const = 0;
  // Whether its points are random, so that Film::estimated_rmse() and until_rmse mean something.
  virtual bool estimates_error() const = 0;
  // What else its pictures have, of planes.reasons: why samples were taken, for example. Most have nothing.
  virtual std::vector<std::string> reason_channels() const { return {}; }
  // Whether it looks at the geometry of samples, so that a source that may leave it out shall tell it.
  virtual bool uses_geometry() const { return false; }
  // The most it can ask a source of that size for, in all.
  virtual uint64_t most_samples(int width, int height) const = 0;
  // What it gives each pixel of the film.
  virtual Film::Holds film_holds() const { return Film::Holds::kMany; }
  // The picture of the whole film. The same bits for any number of threads and any tile. Ended early, it is what
  // was done so far: passes go over the whole picture, so all of it is there, with more noise. (But not before
  // options.soon_s: until then some parts may have many samples and others none.)
  // Throws what the source throws; Error(kUsage) for until_rmse if estimates_error() is false.
  virtual RenderResult render(const Source& source, const RenderOptions& options) const = 0;
};

// All strategies, in the order in which they are listed.
std::vector<const StrategyInfo*> strategy_list();
// "control", "grid:n=4". Throws Error(kUsage) naming `option`, the strategy or parameter, and what would be right.
std::unique_ptr<Strategy> make_strategy(const std::string& text, const std::string& option);
// The strategy's documentation as text, for a terminal.
std::string strategy_help(const StrategyInfo& info);

}  // namespace triad
