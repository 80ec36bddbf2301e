// SPDX-License-Identifier: Apache-2.0
// Where samples come from: a ray tracer, a function with known integrals, a large picture.
//
// Film positions are in pixels of the picture that the source was made for: x to the right, y down, pixel (x, y)
// covers [x, x + 1) by [y, y + 1). For a wide render of W x H display pixels with n x m cells, the source is made
// for a film of n W by m H pixels that shows the same view; it never needs to know about cells.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace triad {

struct SampleRequest {
  double x = 0, y = 0;               // film position; may lie outside the film (a wide reconstruction filter)
  float footprint_px = 1;            // side of the square of film that this sample stands for: 1 for one a pixel
  int32_t pixel_x = 0, pixel_y = 0;  // with index and seed, the key of every random number: see SampleRandom
  uint32_t index = 0;                // of the sample within its pixel, from 0
  uint64_t seed = 0;
};

// Whether both are of the same pixel.
inline bool same_pixel(const SampleRequest& a, const SampleRequest& b) {
  static_assert(offsetof(SampleRequest, pixel_y) == offsetof(SampleRequest, pixel_x) + 4);
  uint64_t pixel_a, pixel_b;  // in one load and one comparison
  std::memcpy(&pixel_a, &a.pixel_x, sizeof(pixel_a));
  std::memcpy(&pixel_b, &b.pixel_x, sizeof(pixel_b));
  return pixel_a == pixel_b;
}

// A batch of pixels one after the other, with `each` samples of every pixel (at least 1, and all complete), may be
// said by the first request of each pixel alone. This sets the others' footprint and pixel, which are the first
// one's, and index, which counts up from there.
void say_all(std::span<SampleRequest> requests, size_t each);

// Scene-linear, BT.709 primaries. A source without geometry leaves the fields after `valid` as they were.
struct Sample {
  std::array<float, 3> rgb{};
  bool valid = true;  // false: the source could not find a value; whoever sums leaves it out, and counts it
  float distance = std::numeric_limits<float>::infinity();  // to the first hit, in scene units; infinite: a miss
  std::array<float, 3> position{};                          // of the first hit, scene coordinates
  std::array<float, 3> normal{};                            // there, unit length, towards the viewer; 0 on a miss
  std::array<float, 3> albedo{};                            // there, in [0, 1]
  uint32_t object_id = 0, material_id = 0;                  // from 1; 0: a miss, or not known
};

// Which of a sample's fields a source with geometry knows; of the others it gives what is said of it.
struct KnownGeometry {
  bool distance = true, position = true, normal = true, albedo = true, object_id = true, material_id = true;
};

struct SourceAbilities {
  bool geometry = false;        // distance, position, normal, albedo and ids mean something
  bool exact_integral = false;  // integral() answers
  bool deterministic = false;   // rgb depends on x, y and footprint_px only, not on the random key
  KnownGeometry known{};        // if there is geometry
};

// A separable filter f(x) f(y) / (integral of f)^2 that is the same both ways, as closed forms need it. Lengths in
// pixels of the film.
struct SeparableFilter {
  double gaussian_sigma_px = 0;  // above 0: exp(-x^2 / 2 sigma^2) without end, and the others do not matter
  double radius_px = 0;          // f is 0 beyond
  // The integral of f up to t, divided by that over all: 0 at -radius_px, 1 at radius_px.
  std::function<double(double t)> cumulative{};
};

// One kind of work and how often it was done, for reports: {"camera rays", 90000}.
struct WorkCount {
  std::string kind;
  uint64_t count = 0;
};

// Implementations: eval() is pure (same requests, same bits, however they are batched), may be called from many
// threads at once, and leaves the thread's floating-point modes as it found them. Requests of neighbouring film
// positions come together, at least a few hundred at a time, so that packets of rays pay. A value that is not
// finite may be returned: the film leaves it out and counts it. Errors are thrown as triad::Error.
class Source {
 public:
  virtual ~Source() = default;

  // The film it was made for, in pixels; both at least 1.
  virtual int width() const = 0;
  virtual int height() const = 0;
  virtual SourceAbilities abilities() const = 0;

  // samples[i] answers requests[i]; both have the same size. rgb and valid of every sample are written, the other
  // fields if abilities().geometry: hand in samples as they are made.
  virtual void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const = 0;

  // The integral of rgb over the box [x0, x1] x [y0, y1] of the film, divided by its area, to double precision;
  // nothing if abilities().exact_integral is false.
  virtual std::optional<std::array<double, 3>> integral(double x0, double y0, double x1, double y1) const;

  // The mean of rgb weighted by the filter centred on (x, y), to double precision; nothing where no closed form is
  // known for it. (The box of half a pixel's radius is integral()'s.)
  virtual std::optional<std::array<double, 3>> filtered(double x, double y, const SeparableFilter& filter) const;

  // What was done since the source was made, in a fixed order, kinds that were never needed included with 0.
  virtual std::vector<WorkCount> work() const { return {}; }
};

inline std::optional<std::array<double, 3>> Source::integral(double, double, double, double) const { return {}; }
inline std::optional<std::array<double, 3>> Source::filtered(double, double, const SeparableFilter&) const {
  return {};
}

// Counts what is asked of another source, so that no strategy can misreport its cost. The other source must
// outlive it.
class CountingSource final : public Source {
 public:
  explicit CountingSource(const Source& source) : source_(source) {}

  int width() const override { return source_.width(); }
  int height() const override { return source_.height(); }
  SourceAbilities abilities() const override { return source_.abilities(); }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    samples_.fetch_add(requests.size(), std::memory_order_relaxed);
    source_.eval(requests, samples);
  }
  std::optional<std::array<double, 3>> integral(double x0, double y0, double x1, double y1) const override {
    return source_.integral(x0, y0, x1, y1);
  }
  std::optional<std::array<double, 3>> filtered(double x, double y, const SeparableFilter& filter) const override {
    return source_.filtered(x, y, filter);
  }
  std::vector<WorkCount> work() const override { return source_.work(); }

  uint64_t samples() const { return samples_.load(std::memory_order_relaxed); }

 private:
  const Source& source_;
  alignas(64) mutable std::atomic<uint64_t> samples_{0};  // in a cache line of its own: every thread writes it
};

}  // namespace triad
