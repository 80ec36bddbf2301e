// SPDX-License-Identifier: Apache-2.0
// Where samples are summed: a weightless accumulator for strategies that keep each sample within its pixel.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <triad/image/image.hpp>
#include <triad/numeric/sum.hpp>
#include <triad/numeric/widest.hpp>
#include <triad/numeric/zero_pages.hpp>
#include <triad/sampling/source.hpp>
#include <vector>

namespace triad {

// What a film keeps besides colour; each costs memory (bytes per pixel) and a little time.
struct FilmPlanes {
  bool error = false;        // 28: two halves of the samples, for estimated_rmse()
  bool variance = false;     // 48: Welford's running variance, for variance_of_mean()
  bool depth = false;        // 8
  bool position = false;     // 24
  bool normal = false;       // 24
  bool albedo = false;       // 24
  bool object_id = false;    // 4
  bool material_id = false;  // 4
  bool samples = false;      // 0: written to the picture
  bool reasons = false;      // 0: not the film's: Strategy::reason_channels()
  bool operator==(const FilmPlanes&) const = default;
};
// "depth,normal,object-id": names out of depth, position, normal, albedo, object-id, material-id, variance, samples,
// reasons; "" is none. Throws Error(kUsage) naming `option`.
FilmPlanes parse_planes(const std::string& text, const std::string& option);
// Those names, for help texts.
std::vector<std::string> plane_names();
// The channels of Film::image(), which has no reasons.
std::vector<std::string> film_channels(const FilmPlanes& planes);
// Throws Error(kInput) if this machine has not the memory for such a film, and `more_bytes` beside it; then `advice`
// says what to ask for instead. Counts what a film of many takes; those of few are smaller.
void require_film_memory(int width, int height, const FilmPlanes& planes, double more_bytes = 0,
                         const std::string& advice = "a smaller --size");

// How a batch of samples lies on a film, for who knows it: rows of pixels, and with `each` samples of every pixel one
// pixel's after the other's. With each = 0 it is looked for, which takes longer and changes nothing.
struct FilmRow {
  size_t pixel, n;  // the first, and how many
};
struct FilmRows {
  size_t each = 0;
  std::span<const FilmRow> rows{};
};

// Sums are exact to about 2^-53 of the sum's size (Neumaier's compensation), unless Holds says otherwise. Their bits
// depend on the order in which one pixel's samples come and on how they are parted into calls, and on nothing else.
// Different threads may add to different pixels at the same time.
class Film {
 public:
  // How many samples a pixel is given at most. A film that keeps colours only takes 12 bytes a pixel of one each,
  // 16 of a few, up to kMostFew, 32 of some, up to kMostSome, and 56 of many, and is as much faster to walk through.
  // With one each, a second sample is a defect of the caller's. Of a few, the mean is rounded to float, as pictures
  // are, whenever some are added: it is rounded once if all come in one call, or the first alone in one before, and
  // so is the picture that of a film of many, bit for bit. Sums of some are not compensated: they are exact to
  // kMostSome * 2^-53, or 2^-45, of the sum of the magnitudes, where pictures are to 2^-25.
  enum class Holds { kMany, kSome, kFew, kOneEach };
  static constexpr uint32_t kMostFew = 16, kMostSome = 256;
  // Throws as require_film_memory() does, before any memory is taken.
  Film(int width, int height, const FilmPlanes& planes, Holds holds = Holds::kMany);

  int width() const { return width_; }
  int height() const { return height_; }
  const FilmPlanes& planes() const { return planes_; }
  size_t pixel(int x, int y) const { return static_cast<size_t>(y) * static_cast<size_t>(width_) + x; }
  size_t pixels() const { return static_cast<size_t>(width_) * static_cast<size_t>(height_); }
  // A hint that samples of the pixel will be added soon: brings it near.
  TRIAD_INLINE_BODY void expect(size_t pixel) const { __builtin_prefetch(record(pixel), 1); }
  // The same of n in a row, n > 0.
  void expect(size_t first, size_t n) const {
    constexpr size_t kLine = 64;  // bytes, of the processors' caches
    const char *const begin = record(first), *const past = record(first + n);
    for (const char* at = begin; at < past; at += kLine) __builtin_prefetch(at, 1);
    __builtin_prefetch(past - 1, 1);
  }

  // Adds the pixel's sample number `index`. False, and nothing was added, if it is not valid or its colour not
  // finite. (Geometry that is not finite only leaves the geometry's planes as they are.)
  bool add(size_t pixel, uint32_t index, const Sample& sample);
  // The same, faster, for many samples at once, whose requests say pixels and indices. Returns where in the spans
  // those stand that were left out.
  std::vector<size_t> add(std::span<const SampleRequest> requests, std::span<const Sample> samples,
                          const FilmRows& rows = {});

  // Whether it keeps colours, and perhaps their halves, and nothing else. Then samples can be summed before:
  bool keeps_sums() const { return colour_only_ && holds_ != Holds::kOneEach; }
  // Whether it rounds means to float.
  bool keeps_means() const { return holds_ == Holds::kFew; }
  // Red, green and blue, and how many samples they are of.
  typedef double SampleSum __attribute__((vector_size(32)));
  // Adds samples that are all kept, as exactly as they were summed; with planes().error, those of them for which
  // sobol_half() is 1 by themselves, too.
  TRIAD_INLINE_BODY void add_sum(size_t pixel, const SampleSum& samples);
  TRIAD_INLINE_BODY void add_half_sum(size_t pixel, const SampleSum& samples);
  // n samples, n > first_alone, each in the pixel that `of_three` says, 0, 1 or 2, out of three in a row: as if those
  // in one pixel were summed and added by add_sum(), and with first_alone, if it is the very first of all three, the
  // first one by itself. False, and nothing was added, if that cannot be done here and now: only some processors do
  // it, without planes().error, and where all are valid and finite.
  bool add_to_three(size_t first, std::span<const Sample> samples, const uint32_t* of_three, bool first_alone);
  // Counts one that is not kept.
  void leave_out(size_t pixel);
  uint32_t count(size_t pixel) const {
    return holds_ == Holds::kMany   ? colour_[pixel].count
           : holds_ == Holds::kSome ? some_[pixel].count
           : holds_ == Holds::kFew  ? few_[pixel].count
                                    : ones_[pixel].is_kept();
  }
  // How many of the pixel's samples add() left out.
  uint32_t left_out(size_t pixel) const {
    return holds_ == Holds::kMany   ? colour_[pixel].left_out
           : holds_ == Holds::kSome ? some_[pixel].left_out
           : holds_ == Holds::kFew  ? few_[pixel].left_out
                                    : ones_[pixel].is_left_out();
  }
  // Whether more samples will not help, as far as anybody can tell: there is none, and a few were left out.
  bool has_nothing(size_t pixel) const { return count(pixel) == 0 && left_out(pixel) >= kFewForNothing; }
  static constexpr uint32_t kFewForNothing = 4;  // one that is lost only in part has likely kept one by then
  // Of the colour; 0 without samples.
  std::array<double, 3> mean(size_t pixel) const;
  // The same of the samples for which sobol_half() is 1, and their number. Needs planes().error.
  uint32_t half_count(size_t pixel) const { return half_[pixel].count; }
  std::array<double, 3> half_mean(size_t pixel) const;
  // s^2 / n, with s^2 the unbiased variance of the n samples (Welford, Technometrics 4(3), 1962); 0 for n < 2, never
  // negative. For independent samples it is the variance of mean(). For stratified ones (sobol-owen) it is too
  // large, and for a fixed grid it only says how much a pixel varies. Needs planes().variance.
  std::array<double, 3> variance_of_mean(size_t pixel) const;
  // The root of the mean, over pixels and channels, of the estimated squared error of mean(), which is to say of
  // (a - b)^2 n_a n_b / n^2 with a and b the means of two halves of the samples. Which half a sample is in is the
  // first digit of a third Sobol dimension (sobol_half()), so that each half of scrambled Sobol points is again well
  // distributed and the gain from stratification is seen; as the halves are a little better together than apart,
  // the estimate errs
  // on the large side. A picture of fewer than 256 pixels has too few such differences: it takes
  // variance_of_mean(). Pixels that has_nothing() is true of have no error, and are left out of
  // the mean: a hole in a picture is not noise that more samples would take away. Infinite until every other pixel
  // has both halves, and where there is no other.
  double estimated_rmse() const;

  // Colour as R, G, B, then the planes asked for: Z (mean over the samples that hit; infinite if none did), P.X
  // P.Y P.Z and N.X N.Y N.Z (likewise, 0 if none; a mean normal is shorter than 1), albedo.R G B (mean over all
  // samples), object_id and material_id (of the first sample), variance.R G B, samples. All float.
  Image image() const;

 private:
  int width_, height_;
  FilmPlanes planes_;
  bool wide_;  // the processor has AVX-512
  // Sums side by side, so that three channels and a lane that means nothing are one load and one store.
  struct Colour {
    std::array<double, 3> sum{}, compensation{};
    uint32_t count = 0, left_out = 0;
    double value(size_t c) const { return NeumaierSum{sum[c], compensation[c]}.value(); }
    // False: it cannot be kept, and was counted only.
    bool add(const Sample& sample);
  };
  struct Some {
    std::array<double, 3> sum;
    uint32_t count, left_out;
  };
  struct Few {
    std::array<float, 3> rgb;  // mean
    uint16_t count, left_out;
  };
  // A colour's bits, which are never those of kNothing, such that all bytes are 0 if there is none yet.
  struct One {
    static constexpr uint32_t kNothing = 0x7fc00001, kLeftOut = 1;  // a not-a-number; what `rgb` is then
    std::array<uint32_t, 3> rgb;                                    // each as bits ^ kNothing
    std::array<float, 3> colour() const;
    bool is_none() const { return rgb[0] == 0; }
    bool is_left_out() const { return rgb[0] == kLeftOut; }
    bool is_kept() const { return !is_none() && !is_left_out(); }
  };
  // As holds_ says, one of the four.
  std::vector<Colour, ZeroPageAllocator<Colour>> colour_;
  std::vector<Some, ZeroPageAllocator<Some>> some_;
  std::vector<Few, ZeroPageAllocator<Few>> few_;
  std::vector<One, ZeroPageAllocator<One>> ones_;
  struct Half {  // of the samples in half 1
    std::array<double, 3> sum{};
    uint32_t count = 0;
  };
  std::vector<Half> half_;
  struct Moments {
    std::array<double, 3> mean{}, m2{};
  };
  std::vector<Moments> moments_;
  std::vector<uint32_t> hits_;
  std::vector<double> depth_;
  std::vector<std::array<double, 3>> position_, normal_, albedo_;
  std::vector<uint32_t> object_id_, material_id_;
  TRIAD_INLINE_BODY const char* record(size_t pixel) const {
    return holds_ == Holds::kMany   ? reinterpret_cast<const char*>(colour_.data() + pixel)
           : holds_ == Holds::kSome ? reinterpret_cast<const char*>(some_.data() + pixel)
           : holds_ == Holds::kFew  ? reinterpret_cast<const char*>(few_.data() + pixel)
                                    : reinterpret_cast<const char*>(ones_.data() + pixel);
  }
  Holds holds_;  // kMany, whatever was asked for, where more than colours are kept
  bool add_one(size_t pixel, const Sample& sample);
  bool add_some(size_t pixel, const Sample& sample);
  static Colour sums_of(const Few& few);
  static void put_mean(const Colour& colour, Few& few);
  bool add_few(Few& few, std::span<const Sample> samples);
  void add_ones(const FilmRows& rows, std::span<const SampleRequest> requests, std::span<const Sample> samples,
                std::vector<size_t>& left_out);
  size_t add_few_by_hand(const FilmRows& rows, std::span<const Sample> samples);
  template <bool kHalves>
  bool add_run(Colour& colour, Half* half, std::span<const SampleRequest> requests, std::span<const Sample> samples);
  void add_planes(size_t pixel, uint32_t count, const Sample& sample);
  enum class Keeps { kFew, kColour, kHalves, kMore };
  template <Keeps kKeeps>
  void add_runs(std::span<const SampleRequest> requests, std::span<const Sample> samples, size_t each,
                std::vector<size_t>& left_out);
  void add_one_by_one(std::span<const SampleRequest> requests, std::span<const Sample> samples, size_t first,
                      size_t past, std::vector<size_t>& left_out);
  bool colour_only_;  // and halves, if there are any
};

TRIAD_INLINE_BODY inline void Film::add_sum(size_t pixel, const SampleSum& samples) {
  if (keeps_means()) {
    Few& few = few_[pixel];
    const double before = few.count, after = before + samples[3], share = 1 / std::max(1., after);
    std::array<float, 3> mean;
    for (size_t c = 0; c < 3; ++c) mean[c] = static_cast<float>((few.rgb[c] * before + samples[c]) * share);
    few.rgb = mean;
    few.count = static_cast<uint16_t>(static_cast<int32_t>(after));
    return;
  }
  using Four = SampleSum;
  constexpr Four kNothing{};
  if (holds_ == Holds::kSome) {
    Some& some = some_[pixel];
    const uint32_t count = some.count + static_cast<uint32_t>(static_cast<int32_t>(samples[3]));
    const uint32_t left_out = some.left_out;
    static_assert(sizeof(Some) == sizeof(Four));
    Four sum;
    std::memcpy(&sum, &some, sizeof(sum));
    sum = __builtin_shufflevector(sum, kNothing, 0, 1, 2, 4) + samples;
    std::memcpy(static_cast<void*>(&some), &sum, sizeof(sum));
    some.count = count;
    some.left_out = left_out;
    return;
  }
  Colour& colour = colour_[pixel];
  // A fourth lane of either is what follows in the record: it is stored, too, and then written anew.
  constexpr size_t kThree = 3 * sizeof(double);
  static_assert(sizeof(Colour) >= kThree + sizeof(Four));
  char* const record = reinterpret_cast<char*>(&colour);
  const uint32_t count = colour.count + static_cast<uint32_t>(static_cast<int32_t>(samples[3]));
  const uint32_t left_out = colour.left_out;
  Four sum, lost;
  std::memcpy(&sum, record, sizeof(sum));
  std::memcpy(&lost, record + kThree, sizeof(lost));
  sum = __builtin_shufflevector(sum, kNothing, 0, 1, 2, 4);
  lost = __builtin_shufflevector(lost, kNothing, 0, 1, 2, 4);
  // Knuth's TwoSum.
  const Four after = sum + samples, came = after - sum;
  lost += (sum - (after - came)) + (samples - came);
  std::memcpy(record, &after, sizeof(after));
  std::memcpy(record + kThree, &lost, sizeof(lost));
  colour.count = count;
  colour.left_out = left_out;
}
TRIAD_INLINE_BODY inline void Film::add_half_sum(size_t pixel, const SampleSum& samples) {
  for (size_t c = 0; c < 3; ++c) half_[pixel].sum[c] += samples[c];
  half_[pixel].count += static_cast<uint32_t>(samples[3]);
}
inline void Film::leave_out(size_t pixel) {
  if (holds_ == Holds::kOneEach)
    ones_[pixel].rgb[0] = One::kLeftOut;
  else if (holds_ == Holds::kFew)
    ++few_[pixel].left_out;
  else if (holds_ == Holds::kSome)
    ++some_[pixel].left_out;
  else
    ++colour_[pixel].left_out;
}

}  // namespace triad
