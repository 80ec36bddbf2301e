// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/base/random.hpp>
#include <triad/base/text.hpp>
#include <triad/sampling/strokes.hpp>

namespace triad {
namespace {

constexpr int kBucket_px = 16;

bool covers(const Stroke& stroke, double x, double y) {
  const double ax = stroke.x1 - stroke.x0, ay = stroke.y1 - stroke.y0, length = std::hypot(ax, ay);
  const double dx = x - stroke.x0, dy = y - stroke.y0;
  const double along = dx * ax + dy * ay, across = dx * ay - dy * ax;
  return along >= 0 && along < length * length && std::abs(across) < .5 * stroke.width_px * length;
}

// Random numbers of one stroke, in [0, 1).
class Dice {
 public:
  Dice(size_t stroke, uint64_t seed) : random_(static_cast<int32_t>(stroke), 0, 0, seed) {}
  double roll() { return static_cast<double>(random_.uniform(dimension_++)); }
  double between(double low, double high) { return low + (high - low) * roll(); }

 private:
  SampleRandom random_;
  uint32_t dimension_ = SampleRandom::kFirstSourceDimension;
};

std::vector<Stroke> at_random_angles(int width_px, int height_px, bool coloured, uint64_t seed) {
  constexpr double kThinnest_px = .5, kWidest_px = 2, kShortest_px = 10, kLongest_px = 60;
  constexpr double kGround_px2 = 280;  // for each stroke, of 44 on average
  const double area = static_cast<double>(width_px) * height_px;
  std::vector<Stroke> strokes(static_cast<size_t>(std::ceil(area / kGround_px2)));
  for (size_t i = 0; i < strokes.size(); ++i) {
    Dice dice(i, seed);
    const double x = dice.between(0, width_px), y = dice.between(0, height_px);
    const double angle = dice.between(0, std::numbers::pi), half = .5 * dice.between(kShortest_px, kLongest_px);
    const double dx = half * std::cos(angle), dy = half * std::sin(angle);
    strokes[i] = {x - dx, y - dy, x + dx, y + dy, dice.between(kThinnest_px, kWidest_px), {1, 1, 1}};
    if (coloured)
      for (float& channel : strokes[i].colour) channel = static_cast<float>(dice.roll());
  }
  return strokes;
}

// Letters of three strokes at most, on lines, where no pixel grid helps them.
std::vector<Stroke> stems(int width_px, int height_px, uint64_t seed) {
  constexpr double kLine_px = 15.3, kHeight_px = 9.4, kLetter_px = 7.37, kBetween_px = 1.9, kStem_px = 1.3;
  constexpr double kBlank = .16;  // of the letters are gaps between words
  const Rgb black{0, 0, 0};
  std::vector<Stroke> strokes;
  size_t letter = 0;
  for (double y = 3; y < height_px; y += kLine_px)
    for (double x = 2.2; x < width_px; x += kLetter_px) {
      Dice dice(letter++, seed);
      if (dice.roll() < kBlank) continue;
      const double left = x, right = x + kLetter_px - kBetween_px, bottom = y + kHeight_px;
      const double bar = y + kHeight_px * dice.roll();
      strokes.push_back({left, y, left, bottom, kStem_px, black});
      if (dice.roll() < .6) strokes.push_back({right, y, right, bottom, kStem_px, black});
      if (dice.roll() < .7) strokes.push_back({left, bar, right, bar, kStem_px, black});
    }
  return strokes;
}

}  // namespace

StrokesSource::StrokesSource(int width_px, int height_px, const Cells& cells, const Rgb& background,
                             std::vector<Stroke> strokes)
    : width_(width_px * cells.x),
      height_(height_px * cells.y),
      columns_((width_px - 1) / kBucket_px + 1),
      rows_((height_px - 1) / kBucket_px + 1),
      cells_(cells),
      background_(background),
      strokes_(std::move(strokes)),
      buckets_(static_cast<size_t>(columns_) * static_cast<size_t>(rows_)) {
  const auto bucket = [](double v_px, int count) {
    return static_cast<int>(std::clamp(std::floor(v_px / kBucket_px), 0., count - 1.));
  };
  for (size_t i = 0; i < strokes_.size(); ++i) {
    const Stroke& s = strokes_[i];
    const double reach = .5 * s.width_px;
    for (int r = bucket(std::min(s.y0, s.y1) - reach, rows_); r <= bucket(std::max(s.y0, s.y1) + reach, rows_); ++r)
      for (int c = bucket(std::min(s.x0, s.x1) - reach, columns_);
           c <= bucket(std::max(s.x0, s.x1) + reach, columns_); ++c)
        buckets_[static_cast<size_t>(r) * static_cast<size_t>(columns_) + static_cast<size_t>(c)].push_back(
            static_cast<int>(i));
  }
}

Rgb StrokesSource::at(double x_px, double y_px) const {
  const int c = std::clamp(static_cast<int>(std::floor(x_px / kBucket_px)), 0, columns_ - 1);
  const int r = std::clamp(static_cast<int>(std::floor(y_px / kBucket_px)), 0, rows_ - 1);
  const auto& near = buckets_[static_cast<size_t>(r) * static_cast<size_t>(columns_) + static_cast<size_t>(c)];
  for (auto i = near.rbegin(); i != near.rend(); ++i)
    if (covers(strokes_[static_cast<size_t>(*i)], x_px, y_px)) return strokes_[static_cast<size_t>(*i)].colour;
  return background_;
}

void StrokesSource::eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const {
  for (size_t i = 0; i < requests.size(); ++i) {
    samples[i] = Sample{};
    samples[i].rgb = at(requests[i].x / cells_.x, requests[i].y / cells_.y);
  }
}

const std::vector<std::string>& stroke_picture_names() {
  static const std::vector<std::string> kNames{"strokes", "colours", "stems"};
  return kNames;
}

std::unique_ptr<Source> make_strokes(const std::string& name, int width_px, int height_px, const Cells& cells,
                                     uint64_t seed) {
  const auto make = [&](const Rgb& background, std::vector<Stroke> strokes) {
    return std::make_unique<StrokesSource>(width_px, height_px, cells, background, std::move(strokes));
  };
  if (name == "strokes") return make({0, 0, 0}, at_random_angles(width_px, height_px, false, seed));
  if (name == "colours") return make({0, 0, 0}, at_random_angles(width_px, height_px, true, seed));
  if (name == "stems") return make({1, 1, 1}, stems(width_px, height_px, seed));
  throw_usage("no picture is called '" + name + "'" + did_you_mean(name, stroke_picture_names()) + "; there are '" +
              join(stroke_picture_names(), "', '") + "'");
}

}  // namespace triad
