// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/cell_sums_avx512.hpp>
#include <triad/sampling/film.hpp>
#include <triad/sampling/hot_avx512.hpp>
#include <triad/sampling/sobol.hpp>

namespace triad {
namespace {

constexpr struct {
  const char* name;
  bool FilmPlanes::*member;
} kPlanes[] = {{"depth", &FilmPlanes::depth},         {"position", &FilmPlanes::position},
               {"normal", &FilmPlanes::normal},       {"albedo", &FilmPlanes::albedo},
               {"object-id", &FilmPlanes::object_id}, {"material-id", &FilmPlanes::material_id},
               {"variance", &FilmPlanes::variance},   {"samples", &FilmPlanes::samples},
               {"reasons", &FilmPlanes::reasons}};

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr size_t kFewPixels = 256;  // the relative error of a mean of 3 x 256 squared normals is 5%

typedef int32_t FourInts __attribute__((vector_size(16)));
typedef int64_t TwoWords __attribute__((vector_size(16)));
typedef float FourFloats __attribute__((vector_size(16)));
typedef double Four __attribute__((vector_size(32)));
typedef int32_t EightInts __attribute__((vector_size(32)));
typedef float EightFloats __attribute__((vector_size(32)));
typedef double Eight __attribute__((vector_size(64)));

bool finite(const std::array<float, 3>& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

void add_to(std::array<double, 3>& sum, const std::array<float, 3>& v) {
  for (int c = 0; c < 3; ++c) sum[c] += v[c];
}

}  // namespace

std::vector<std::string> plane_names() {
  std::vector<std::string> names;
  for (const auto& plane : kPlanes) names.emplace_back(plane.name);
  return names;
}

FilmPlanes parse_planes(const std::string& text, const std::string& option) {
  FilmPlanes planes;
  if (text.empty()) return planes;
  for (const std::string& name : split_quoted(text, ',')) {
    const auto* found =
        std::find_if(std::begin(kPlanes), std::end(kPlanes), [&](const auto& p) { return p.name == name; });
    if (found == std::end(kPlanes))
      throw_usage(option + ": '" + name + "' is not known" + did_you_mean(name, plane_names()) + "; there are " +
                  join(plane_names(), ", "));
    planes.*(found->member) = true;
  }
  return planes;
}

std::vector<std::string> film_channels(const FilmPlanes& planes) {
  std::vector<std::string> channels{"R", "G", "B"};
  const auto name = [&](bool wanted, std::initializer_list<const char*> names) {
    if (wanted) channels.insert(channels.end(), names.begin(), names.end());
  };
  name(planes.depth, {"Z"});
  name(planes.position, {"P.X", "P.Y", "P.Z"});
  name(planes.normal, {"N.X", "N.Y", "N.Z"});
  name(planes.albedo, {"albedo.R", "albedo.G", "albedo.B"});
  name(planes.object_id, {"object_id"});
  name(planes.material_id, {"material_id"});
  name(planes.variance, {"variance.R", "variance.G", "variance.B"});
  name(planes.samples, {"samples"});
  return channels;
}

void require_film_memory(int width, int height, const FilmPlanes& planes, double more_bytes,
                         const std::string& advice) {
  const size_t each = 56 + 32 * planes.error + 48 * planes.variance + 12 * planes.depth + 24 * planes.position +
                      24 * planes.normal + 24 * planes.albedo + 4 * planes.object_id + 4 * planes.material_id +
                      sizeof(float) * film_channels(planes).size();  // and the picture made of it
  const double bytes = static_cast<double>(each) * width * height + more_bytes;
  if (bytes > static_cast<double>(machine_memory_bytes()))
    throw_input("a picture of " + std::to_string(width) + "x" + std::to_string(height) + " pixels takes " +
                format_double(std::ceil(bytes / 1e9)) + " GB of memory, and this machine has " +
                format_bytes(machine_memory_bytes()) + "; ask for " + advice);
}

Film::Film(int width, int height, const FilmPlanes& planes, Holds holds)
    : width_(width), height_(height), planes_(planes), wide_(default_cpu_path() == CpuPath::kAvx512) {
  if (width < 1 || height < 1) throw_internal("a film of " + std::to_string(width) + "x" + std::to_string(height));
  require_film_memory(width, height, planes);
  const size_t n = static_cast<size_t>(width) * static_cast<size_t>(height);
  if (planes.error) half_.resize(n);
  if (planes.variance || (planes.error && n < kFewPixels)) moments_.resize(n);
  if (planes.depth || planes.position || planes.normal) hits_.resize(n);
  if (planes.depth) depth_.resize(n);
  if (planes.position) position_.resize(n);
  if (planes.normal) normal_.resize(n);
  if (planes.albedo) albedo_.resize(n);
  if (planes.object_id) object_id_.resize(n);
  if (planes.material_id) material_id_.resize(n);
  FilmPlanes free = planes;
  free.samples = free.reasons = free.error = false;
  colour_only_ = free == FilmPlanes{} && moments_.empty();
  holds_ = colour_only_ && !planes.error ? holds : Holds::kMany;
  if (holds_ == Holds::kMany)
    colour_.resize(n);
  else if (holds_ == Holds::kSome)
    some_.resize(n);
  else if (holds_ == Holds::kFew)
    few_.resize(n);
  else
    ones_.resize(n);
}

bool Film::Colour::add(const Sample& sample) {
  if (!sample.valid || !finite(sample.rgb)) {
    ++left_out;
    return false;
  }
  ++count;
  for (size_t c = 0; c < 3; ++c) {
    NeumaierSum each{sum[c], compensation[c]};
    each.add(sample.rgb[c]);
    sum[c] = each.sum;
    compensation[c] = each.compensation;
  }
  return true;
}

// Most often all can be kept, and are written as they are looked at.
void Film::add_ones(const FilmRows& rows, std::span<const SampleRequest> requests, std::span<const Sample> samples,
                    std::vector<size_t>& left_out) {
  constexpr int32_t kExponent = 0x7f800000;  // of a float; all set where it is not finite
  constexpr int32_t kNothing = One::kNothing;
  static_assert(offsetof(Sample, rgb) == 0 && sizeof(Sample) >= sizeof(FourInts));
  static_assert(offsetof(One, rgb) == 0 && sizeof(One) == 3 * sizeof(int32_t));
  FourInts wrong{};
  bool valid = true, none = true;
  const auto put = [&](const Sample& sample, One& one) TRIAD_INLINE_BODY {
    none &= one.is_none();
    FourInts bits;
    std::memcpy(&bits, &sample, sizeof(bits));
    wrong |= (bits & kExponent) == kExponent;
    valid &= sample.valid;
    bits ^= kNothing;
    // Not as twelve bytes, which would go by way of memory.
    const int64_t two = ((TwoWords)bits)[0];
    std::memcpy(&one.rgb[0], &two, sizeof(two));
    const int32_t third = bits[2];
    std::memcpy(&one.rgb[2], &third, sizeof(third));
  };
  const auto pixel_of = [&](size_t i) { return pixel(requests[i].pixel_x, requests[i].pixel_y); };
  if (rows.each == 1) {
    const Sample* sample = samples.data();
    for (const FilmRow& row : rows.rows)
      for (size_t p = row.pixel; p < row.pixel + row.n; ++p) put(*sample++, ones_[p]);
  } else {
    for (size_t i = 0; i < samples.size(); ++i) put(samples[i], ones_[pixel_of(i)]);
  }
  if (!none) throw_internal("a film of one sample a pixel was given a second one");
  if (valid && (wrong[0] | wrong[1] | wrong[2]) == 0) return;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].valid && finite(samples[i].rgb)) continue;
    ones_[pixel_of(i)] = {{One::kLeftOut, 0, 0}};
    left_out.push_back(i);
  }
}

bool Film::add_one(size_t pixel, const Sample& sample) {
  One& one = ones_[pixel];
  if (!one.is_none()) throw_internal("a film of one sample a pixel was given a second one");
  const bool kept = sample.valid && finite(sample.rgb);
  one = {{One::kLeftOut, 0, 0}};
  if (kept)
    for (size_t c = 0; c < 3; ++c) one.rgb[c] = std::bit_cast<uint32_t>(sample.rgb[c]) ^ One::kNothing;
  return kept;
}

bool Film::add_some(size_t pixel, const Sample& sample) {
  Some& some = some_[pixel];
  if (some.count + some.left_out == kMostSome) throw_internal("a film of some samples a pixel was given more");
  const bool kept = sample.valid && finite(sample.rgb);
  ++(kept ? some.count : some.left_out);
  if (kept) add_to(some.sum, sample.rgb);
  return kept;
}

std::array<float, 3> Film::One::colour() const {
  std::array<float, 3> colour{};
  if (is_kept())
    for (size_t c = 0; c < 3; ++c) colour[c] = 0 + std::bit_cast<float>(rgb[c] ^ kNothing);  // no -0, as in sums
  return colour;
}

// Compensated sums of the three colours side by side, with the error of each addition by Knuth's TwoSum: that of
// Neumaier's branch, as both are exact. Samples of even and of odd place in the run have sums of their own, which
// wait for each other half as long, and are added at its end. The first sample of all counts as a run of its own, so
// that it does not matter whether the others came along with it. False, and nothing was added, if a sample is not
// valid or not finite.
template <bool kHalves>
TRIAD_INLINE_BODY inline bool Film::add_run(Colour& colour, Half* half_sum, std::span<const SampleRequest> requests,
                                            std::span<const Sample> samples) {
#if defined(__x86_64__)
  if (wide_) {
    const uint32_t n = static_cast<uint32_t>(samples.size());
    static_assert(offsetof(Colour, sum) == 0 && offsetof(Colour, compensation) == 3 * sizeof(double));
    if (!avx512::add_run(reinterpret_cast<double*>(&colour), n > 1 && colour.count + colour.left_out == 0,
                         requests.data(), samples.data(), n, kHalves ? half_sum->sum.data() : nullptr,
                         kHalves ? &half_sum->count : nullptr))
      return false;
    colour.count += n;
    return true;
  }
#endif
  // A fourth lane of either is what follows in the record: it is stored, too, and then written anew.
  constexpr size_t kThree = 3 * sizeof(double);
  static_assert(offsetof(Colour, sum) == 0 && offsetof(Colour, compensation) == kThree &&
                sizeof(Colour) >= kThree + 32);
  char* const record = reinterpret_cast<char*>(&colour);
  constexpr Four kNothing{};
  Four total, lost;
  std::memcpy(&total, record, sizeof(total));
  std::memcpy(&lost, record + kThree, sizeof(lost));
  total[3] = lost[3] = 0;
  // By shuffles: a vector put together in memory would be waited for.
  Eight sum = __builtin_shufflevector(total, kNothing, 0, 1, 2, 3, 4, 5, 6, 7);
  Eight compensation = __builtin_shufflevector(lost, kNothing, 0, 1, 2, 3, 4, 5, 6, 7);
  Eight half{};
  if constexpr (kHalves) std::memcpy(&half, half_sum->sum.data(), kThree);
  uint32_t in_half = 0;
  bool valid = true;
  // The three colours in one load; what follows them is no number.
  static_assert(offsetof(Sample, rgb) == 0 && sizeof(Sample) >= sizeof(FourInts));
  const size_t n = samples.size();
  size_t begin = 0;
  if (n > 1 && colour.count + colour.left_out == 0) {  // nothing is lost of a sum with 0
    FourInts bits;
    std::memcpy(&bits, &samples[0], sizeof(bits));
    valid = samples[0].valid;
    bits &= FourInts{-1, -1, -1, 0};
    FourFloats rgb;
    std::memcpy(&rgb, &bits, sizeof(rgb));
    sum = __builtin_shufflevector(kNothing + __builtin_convertvector(rgb, Four), kNothing, 0, 1, 2, 3, 4, 5, 6, 7);
    if constexpr (kHalves) {
      const double in = sobol_half(requests[0].index);
      half = sum * in;
      in_half = static_cast<uint32_t>(in);
    }
    begin = 1;
  }
  for (size_t i = begin; i < n; i += 2) {
    FourInts even_bits, odd_bits{};
    std::memcpy(&even_bits, &samples[i], sizeof(even_bits));
    valid &= samples[i].valid;
    if (i + 1 < n) {
      std::memcpy(&odd_bits, &samples[i + 1], sizeof(odd_bits));
      valid &= samples[i + 1].valid;
    }
    const EightInts bits = __builtin_shufflevector(even_bits, odd_bits, 0, 1, 2, 3, 4, 5, 6, 7) &
                           EightInts{-1, -1, -1, 0, -1, -1, -1, 0};
    EightFloats rgb;
    std::memcpy(&rgb, &bits, sizeof(rgb));
    const Eight x = __builtin_convertvector(rgb, Eight);
    const Eight after = sum + x, came = after - sum;
    compensation += (sum - (after - came)) + (x - came);
    sum = after;
    if constexpr (kHalves) {
      const double even = sobol_half(requests[i].index), odd = i + 1 < n && sobol_half(requests[i + 1].index);
      half += x * Eight{even, even, even, 0, odd, odd, odd, 0};
      in_half += static_cast<uint32_t>(even + odd);
    }
  }
  total = __builtin_shufflevector(sum, sum, 0, 1, 2, 3);
  lost = __builtin_shufflevector(compensation, compensation, 0, 1, 2, 3);
  const Four others = __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
  const Four lost_of_others = __builtin_shufflevector(compensation, compensation, 4, 5, 6, 7);
  const Four after = total + others, came = after - total;
  lost += ((total - (after - came)) + (others - came)) + lost_of_others;
  // What is not finite stays so in a sum. (A sum of huge ones may be sent away for nothing, to be added one by one.)
  if (!valid || !std::isfinite(after[0] + after[1] + after[2])) return false;
  const uint32_t count = colour.count + static_cast<uint32_t>(n), left_out = colour.left_out;
  std::memcpy(record, &after, sizeof(after));
  std::memcpy(record + kThree, &lost, sizeof(lost));
  colour.count = count;
  colour.left_out = left_out;
  if constexpr (kHalves) {
    for (size_t c = 0; c < 3; ++c) half_sum->sum[c] = half[c] + half[c + 4];
    half_sum->count += in_half;
  }
  return true;
}

Film::Colour Film::sums_of(const Few& few) {
  Colour colour;
  for (size_t c = 0; c < 3; ++c) colour.sum[c] = static_cast<double>(few.rgb[c]) * few.count;  // of one, it is it
  colour.count = few.count;
  colour.left_out = few.left_out;
  return colour;
}

void Film::put_mean(const Colour& colour, Few& few) {
  for (size_t c = 0; c < 3; ++c) few.rgb[c] = static_cast<float>(colour.value(c) / std::max(1u, colour.count));
  few.count = static_cast<uint16_t>(colour.count);
  few.left_out = static_cast<uint16_t>(colour.left_out);
  if (colour.count + colour.left_out > kMostFew) throw_internal("a film of a few samples a pixel was given more");
}

// add_run() of a film of a few.
TRIAD_INLINE_BODY inline bool Film::add_few(Few& few, std::span<const Sample> samples) {
  Colour colour = sums_of(few);
  if (!add_run<false>(colour, nullptr, {}, samples)) return false;
  put_mean(colour, few);
  return true;
}

void Film::add_one_by_one(std::span<const SampleRequest> requests, std::span<const Sample> samples, size_t first,
                          size_t past, std::vector<size_t>& left_out) {
  const size_t p = pixel(requests[first].pixel_x, requests[first].pixel_y);
  if (holds_ == Holds::kMany) {
    for (size_t i = first; i < past; ++i)
      if (!add(p, requests[i].index, samples[i])) left_out.push_back(i);
    return;
  }
  Colour colour = sums_of(few_[p]);
  for (size_t i = first; i < past; ++i)
    if (!colour.add(samples[i])) left_out.push_back(i);
  put_mean(colour, few_[p]);
}

template <Film::Keeps kKeeps>
TRIAD_INLINE_BODY inline void Film::add_runs(std::span<const SampleRequest> requests, std::span<const Sample> samples,
                                             size_t each, std::vector<size_t>& left_out) {
  for (size_t first = 0, past = 0, end = 0; first < requests.size(); first = past) {
    if (first == end) {
      end = first + std::max<size_t>(each, 1);
      if (each == 0)
        while (end < requests.size() && same_pixel(requests[end], requests[first])) ++end;
    }
    past = end;
    const size_t p = pixel(requests[first].pixel_x, requests[first].pixel_y), n = past - first;
    bool fresh, added;
    if constexpr (kKeeps == Keeps::kFew) {
      fresh = few_[p].count + few_[p].left_out == 0;
      added = add_few(few_[p], samples.subspan(first, n));
    } else {
      uint32_t count = colour_[p].count;
      fresh = count + colour_[p].left_out == 0;
      Half* const half = planes_.error ? &half_[p] : nullptr;
      if (kKeeps == Keeps::kHalves || (kKeeps == Keeps::kMore && half))
        added = add_run<true>(colour_[p], half, requests.subspan(first, n), samples.subspan(first, n));
      else
        added = add_run<false>(colour_[p], nullptr, requests.subspan(first, n), samples.subspan(first, n));
      if (kKeeps == Keeps::kMore && added)
        for (size_t i = first; i < past; ++i) add_planes(p, ++count, samples[i]);
    }
    if (!added) {
      if (fresh) past = first + 1;  // as add_run() would have it
      add_one_by_one(requests, samples, first, past, left_out);
    }
  }
}

// The first ones as far as that goes; returns their number.
size_t Film::add_few_by_hand([[maybe_unused]] const FilmRows& rows,
                             [[maybe_unused]] std::span<const Sample> samples) {
  size_t done = 0;
#if defined(__x86_64__)
  static_assert(offsetof(Few, rgb) == 0 && offsetof(Few, count) == 12 && offsetof(Few, left_out) == 14);
  if (!wide_ || rows.each == 0) return 0;
  for (const FilmRow& row : rows.rows) {
    const size_t pixels = avx512::add_few(few_[row.pixel].rgb.data(), row.n, &samples[done], rows.each);
    done += pixels * rows.each;
    if (pixels < row.n) break;
  }
#endif
  return done;
}

std::vector<size_t> Film::add(std::span<const SampleRequest> requests, std::span<const Sample> samples,
                              const FilmRows& rows) {
  std::vector<size_t> left_out;
  const size_t each = rows.each;
  if (holds_ == Holds::kOneEach) {
    add_ones(rows, requests, samples, left_out);
  } else if (holds_ == Holds::kFew) {
    const size_t done = add_few_by_hand(rows, samples);
    if (done == samples.size()) return left_out;
    run_widest([&]() TRIAD_INLINE_BODY {
      add_runs<Keeps::kFew>(requests.subspan(done), samples.subspan(done), each, left_out);
    });
    for (size_t& i : left_out) i += done;
  } else if (holds_ == Holds::kSome) {
    for (size_t i = 0; i < samples.size(); ++i)
      if (!add_some(pixel(requests[i].pixel_x, requests[i].pixel_y), samples[i])) left_out.push_back(i);
  } else if (!colour_only_) {
    add_runs<Keeps::kMore>(requests, samples, each, left_out);
  } else if (planes_.error) {
    run_widest([&]() TRIAD_INLINE_BODY { add_runs<Keeps::kHalves>(requests, samples, each, left_out); });
  } else {
    run_widest([&]() TRIAD_INLINE_BODY { add_runs<Keeps::kColour>(requests, samples, each, left_out); });
  }
  return left_out;
}

bool Film::add_to_three([[maybe_unused]] size_t first, [[maybe_unused]] std::span<const Sample> samples,
                        [[maybe_unused]] const uint32_t* of_three, [[maybe_unused]] bool first_alone) {
#if defined(__x86_64__)
  if (!wide_ || !colour_only_ || planes_.error) return false;
  const size_t n = samples.size();
  if (holds_ == Holds::kFew)
    return avx512::put_few_in_three(few_[first].rgb.data(), samples.data(), of_three, n, first_alone);
  static_assert(offsetof(Some, sum) == 0 && offsetof(Some, count) == 24 && offsetof(Some, left_out) == 28);
  if (holds_ == Holds::kSome)
    return avx512::add_to_three(some_[first].sum.data(), samples.data(), of_three, n, first_alone);
  SampleSum sums[3], one;
  if (holds_ == Holds::kMany && avx512::sums_of_three(samples.data(), of_three, n, first_alone, sums, &one)) {
    if (first_alone) add_sum(first + of_three[0], one);
    for (size_t c = 0; c < 3; ++c) add_sum(first + c, sums[c]);
    return true;
  }
#endif
  return false;
}

bool Film::add(size_t pixel, uint32_t index, const Sample& sample) {
  if (holds_ == Holds::kOneEach) return add_one(pixel, sample);
  if (holds_ == Holds::kSome) return add_some(pixel, sample);
  if (holds_ == Holds::kFew) {
    Colour colour = sums_of(few_[pixel]);
    const bool kept = colour.add(sample);
    put_mean(colour, few_[pixel]);
    return kept;
  }
  Colour& colour = colour_[pixel];
  if (!colour.add(sample)) return false;
  if (planes_.error && sobol_half(index)) {
    add_to(half_[pixel].sum, sample.rgb);
    ++half_[pixel].count;
  }
  if (!colour_only_) add_planes(pixel, colour.count, sample);
  return true;
}

// All but colours and their halves, of the pixel's sample number `count` from 1.
void Film::add_planes(size_t pixel, uint32_t count, const Sample& sample) {
  if (!moments_.empty()) {
    Moments& m = moments_[pixel];
    for (int c = 0; c < 3; ++c) {
      const double before = sample.rgb[c] - m.mean[c];
      m.mean[c] += before / count;
      m.m2[c] += before * (sample.rgb[c] - m.mean[c]);
    }
  }
  if (!hits_.empty() && std::isfinite(sample.distance) && finite(sample.position) && finite(sample.normal)) {
    ++hits_[pixel];
    if (planes_.depth) depth_[pixel] += sample.distance;
    if (planes_.position) add_to(position_[pixel], sample.position);
    if (planes_.normal) add_to(normal_[pixel], sample.normal);
  }
  if (planes_.albedo && finite(sample.albedo)) add_to(albedo_[pixel], sample.albedo);
  if (planes_.object_id && count == 1) object_id_[pixel] = sample.object_id;
  if (planes_.material_id && count == 1) material_id_[pixel] = sample.material_id;
}

std::array<double, 3> Film::mean(size_t pixel) const {
  if (holds_ == Holds::kFew || holds_ == Holds::kOneEach) {
    const std::array<float, 3> colour = holds_ == Holds::kFew ? few_[pixel].rgb : ones_[pixel].colour();
    return {colour[0], colour[1], colour[2]};
  }
  const double n = std::max(1u, count(pixel));
  if (holds_ == Holds::kSome) return {some_[pixel].sum[0] / n, some_[pixel].sum[1] / n, some_[pixel].sum[2] / n};
  return {colour_[pixel].value(0) / n, colour_[pixel].value(1) / n, colour_[pixel].value(2) / n};
}

std::array<double, 3> Film::half_mean(size_t pixel) const {
  if (!planes_.error) throw_internal("a film without halves was asked for one");
  const Half& half = half_[pixel];
  const double n = std::max(1u, half.count);
  return {half.sum[0] / n, half.sum[1] / n, half.sum[2] / n};
}

std::array<double, 3> Film::variance_of_mean(size_t pixel) const {
  if (moments_.empty()) throw_internal("a film without variance was asked for it");
  const double n = colour_[pixel].count;
  if (n < 2) return {};
  const Moments& m = moments_[pixel];
  // Each term of m2 is a product of two numbers of one sign but for rounding.
  return {std::max(0., m.m2[0]) / (n - 1) / n, std::max(0., m.m2[1]) / (n - 1) / n,
          std::max(0., m.m2[2]) / (n - 1) / n};
}

double Film::estimated_rmse() const {
  if (!planes_.error) throw_internal("a film without halves was asked for its error");
  const bool few = pixels() < kFewPixels;
  constexpr size_t kBlock = 8192;  // pixels; always the same, and so is the sum, for any number of threads
  struct Part {
    NeumaierSum sum;
    size_t pixels = 0;
  };
  std::vector<Part> parts((pixels() + kBlock - 1) / kBlock);
  parallel_for(static_cast<int64_t>(parts.size()), [&](int64_t block) {
    Part& part = parts[static_cast<size_t>(block)];
    const size_t first = static_cast<size_t>(block) * kBlock;
    for (size_t p = first; p < std::min(first + kBlock, pixels()); ++p) {
      if (has_nothing(p)) continue;
      ++part.pixels;
      const double n = colour_[p].count, b = half_[p].count, a = n - b;
      if (a < 1 || b < 1) {
        part.sum.add(kInfinity);
        return;
      }
      const std::array<double, 3> variance = few ? variance_of_mean(p) : std::array<double, 3>{};
      for (int c = 0; c < 3; ++c) {
        const double mean_b = half_[p].sum[c] / b,
                     mean_a = (colour_[p].value(static_cast<size_t>(c)) - half_[p].sum[c]) / a;
        part.sum.add(few ? variance[c] : (mean_a - mean_b) * (mean_a - mean_b) * (a / n) * (b / n));
      }
    }
  });
  Part total;
  for (const Part& part : parts) {
    total.sum.merge(part.sum);
    total.pixels += part.pixels;
  }
  return total.pixels > 0 ? std::sqrt(total.sum.value() / (3 * static_cast<double>(total.pixels))) : kInfinity;
}

Image Film::image() const {
  Image image;
  ImageSpec& spec = image.spec;
  spec.width = width_;
  spec.height = height_;
  spec.colour_channels = 3;
  spec.channels = film_channels(planes_);
  image.pixels.reserve(pixels() * spec.channels.size());
  const auto put = [&](double value) { image.pixels.push_back(static_cast<float>(value)); };
  const auto put3 = [&](const std::array<double, 3>& v, double n) {
    for (const double each : v) put(n > 0 ? each / n : 0);
  };
  for (size_t p = 0; p < pixels(); ++p) {
    const double n = count(p), hits = hits_.empty() ? 0 : hits_[p];
    put3(mean(p), 1);
    if (planes_.depth) put(hits > 0 ? depth_[p] / hits : kInfinity);
    if (planes_.position) put3(position_[p], hits);
    if (planes_.normal) put3(normal_[p], hits);
    if (planes_.albedo) put3(albedo_[p], n);
    if (planes_.object_id) put(object_id_[p]);
    if (planes_.material_id) put(material_id_[p]);
    if (planes_.variance) put3(variance_of_mean(p), 1);
    if (planes_.samples) put(n);
  }
  return image;
}

}  // namespace triad
