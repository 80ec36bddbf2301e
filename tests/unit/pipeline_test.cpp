// SPDX-License-Identifier: Apache-2.0
// Chains cut into strips against the same operations on the whole picture.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/image/reader.hpp>
#include <triad/image/writer.hpp>
#include <triad/pipeline/run.hpp>

namespace fs = std::filesystem;
using namespace triad;

namespace {

Image make_image(int width, int height, std::vector<std::string> channels) {
  Image image;
  image.spec.width = width;
  image.spec.height = height;
  image.spec.colour_channels = channels.size() >= 3 ? 3 : 1;
  image.spec.alpha = channels.back() == "A" ? static_cast<int>(channels.size()) - 1 : -1;
  image.spec.channels = std::move(channels);
  image.pixels.resize(static_cast<size_t>(width) * height * image.spec.channels.size());
  uint32_t state = 12345;
  for (float& value : image.pixels) {
    state = state * 1664525u + 1013904223u;
    value = static_cast<float>(state >> 8) * 0x1p-24f;
  }
  return image;
}

using Operation = std::function<Image(const Image&)>;

Image map_pixels(const Image& in, const std::function<float(int x, int y, int c)>& value) {
  Image out = in;
  const int channels = in.spec.channel_count();
  for (int y = 0; y < in.spec.height; ++y)
    for (int x = 0; x < in.spec.width; ++x)
      for (int c = 0; c < channels; ++c) out.row(y)[x * channels + c] = value(x, y, c);
  return out;
}

Image flip(const Image& in) {
  return map_pixels(
      in, [&](int x, int y, int c) { return in.row(in.spec.height - 1 - y)[x * in.spec.channel_count() + c]; });
}

// Beyond the edges by the definitions in words, not by the host's function.
float at(const Image& in, int x, int y, int c, const std::string& edge) {
  const auto place = [&](int i, int n) {
    if (edge == "clamp") return std::clamp(i, 0, n - 1);
    while (i < 0 || i >= n) {
      if (edge == "wrap") i += i < 0 ? n : -n;
      if (edge == "mirror") i = i < 0 ? -1 - i : 2 * n - 1 - i;
      if (edge == "zero") return -1;
    }
    return i;
  };
  const int u = place(x, in.spec.width), v = place(y, in.spec.height);
  return u < 0 || v < 0 ? 0.0f : in.row(v)[u * in.spec.channel_count() + c];
}

Operation cross(int r, std::string edge) {
  return [=](const Image& in) {
    return map_pixels(in, [&](int x, int y, int c) {
      return at(in, x, y, c, edge) + 2 * at(in, x - r, y, c, edge) + 3 * at(in, x + r, y, c, edge) +
             5 * at(in, x, y - r, c, edge) + 7 * at(in, x, y + r, c, edge) + 11 * at(in, x + r, y + r, c, edge);
    });
  };
}

Image normalise(const Image& in) {
  const float largest = *std::max_element(in.pixels.begin(), in.pixels.end());
  return map_pixels(in, [&](int x, int y, int c) { return in.row(y)[x * in.spec.channel_count() + c] / largest; });
}

Image running(const Image& in) {
  std::vector<float> sums;
  float sum = 0;
  for (int y = 0; y < in.spec.height; ++y) sums.push_back(sum += *in.row(y));
  return map_pixels(in, [&](int, int y, int) { return sums[static_cast<size_t>(y)]; });
}

Image mean(const Image& in) {
  double sum = 0;
  for (const float value : in.pixels) sum += value;
  return map_pixels(in,
                    [&](int, int, int) { return static_cast<float>(sum / static_cast<double>(in.pixels.size())); });
}

Image fives(const Image& in) {
  return map_pixels(in, [&](int x, int y, int c) {
    return in.row(y)[x * in.spec.channel_count() + c] + static_cast<float>(y / 5);
  });
}

class Pipeline : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("triad-pipeline-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    fs::remove_all(folder_);
    set_thread_limit(0);
  }
  std::string path(const std::string& name) const { return folder_ / name; }

  std::string store(const std::string& name, const Image& image) const {
    WriteOptions options;
    options.depth = Depth::kFloat;
    write_image(path(name), image, options);
    return path(name);
  }

  RunResult run(RunRequest request) {
    PluginHost host({TRIAD_TEST_STAGES, TRIAD_BINARY_DIR "/plugins"});
    const ColourConfig colours = ColourConfig::load();
    return triad::Run(std::move(request), host, colours).execute();
  }

  // The chain's picture for one way of cutting it.
  Image result(const std::string& input, const std::vector<std::string>& stages, int threads, int strip_rows) {
    set_thread_limit(threads);
    RunRequest request;
    request.input.path = input;
    for (const std::string& stage : stages) request.stages.push_back(parse_stage(stage));
    request.output = path("out.exr");
    request.write.depth = Depth::kFloat;
    request.strip_rows = strip_rows;
    run(request);
    return read_image(request.output);
  }

  fs::path folder_;
};

struct Case {
  std::vector<std::string> stages;
  std::vector<Operation> operations;
};

TEST_F(Pipeline, StripsGiveTheWholePicturesResult) {
  const std::vector<Case> cases{
      {{}, {}},
      {{"flip"}, {flip}},
      {{"cross:radius=3,edge=mirror"}, {cross(3, "mirror")}},
      {{"cross:radius=40,edge=mirror"}, {cross(40, "mirror")}},
      {{"cross:radius=3,edge=wrap"}, {cross(3, "wrap")}},
      {{"cross:radius=2,edge=zero", "cross:radius=5,edge=clamp"}, {cross(2, "zero"), cross(5, "clamp")}},
      {{"normalise"}, {normalise}},
      {{"cross", "normalise", "flip", "normalise"}, {cross(1, "clamp"), normalise, flip, normalise}},
      {{"running"}, {running}},
      {{"fives", "running", "cross:radius=2"}, {fives, running, cross(2, "clamp")}},
      {{"mean"}, {mean}},
      {{"cross", "mean", "fives"}, {cross(1, "clamp"), mean, fives}},
      {{"fives", "cross:radius=4", "fives"}, {fives, cross(4, "clamp"), fives}},
      {{"running", "normalise"}, {running, normalise}},
  };
  for (const auto& [width, height] : std::vector<std::pair<int, int>>{{1, 1}, {7, 1}, {1, 23}, {13, 37}, {31, 130}}) {
    const Image image = make_image(width, height, {"R", "G", "B"});
    const std::string input = store("in.exr", image);
    for (const Case& c : cases) {
      Image expected = image;
      for (const Operation& operation : c.operations) expected = operation(expected);
      for (const auto& [threads, rows] : std::vector<std::pair<int, int>>{{1, 0}, {2, 1}, {7, 3}, {2, 64}}) {
        const Image got = result(input, c.stages, threads, rows);
        ASSERT_EQ(got.pixels, expected.pixels) << width << "x" << height << " " << testing::PrintToString(c.stages)
                                               << " threads " << threads << " rows " << rows;
      }
    }
  }
}

TEST_F(Pipeline, TapsKeepThePictureAtThatPoint) {
  const Image image = make_image(13, 101, {"R", "G", "B"});
  const std::string input = store("in.exr", image);
  for (const int rows : {0, 1, 7, 200}) {
    RunRequest request;
    request.input.path = input;
    request.write.depth = Depth::kFloat;
    for (const std::string& stage :
         {std::string("write:" + path("a.exr")), std::string("cross:radius=2"), std::string("write:" + path("b.exr")),
          std::string("crop:x=2,y=40,w=5,h=9"), std::string("write:" + path("c.exr")), std::string("mean"),
          std::string("write:" + path("d.exr"))})
      request.stages.push_back(parse_stage(stage));
    request.output = path("e.exr");
    request.strip_rows = rows;
    run(request);
    const Image crossed = cross(2, "clamp")(image);
    EXPECT_EQ(read_image(path("a.exr")).pixels, image.pixels) << rows;
    EXPECT_EQ(read_image(path("b.exr")).pixels, crossed.pixels) << rows;
    const Image cropped = read_image(path("c.exr"));
    ASSERT_EQ(cropped.spec.width, 5);
    for (int y = 0; y < 9; ++y)
      for (int i = 0; i < 15; ++i) EXPECT_EQ(cropped.row(y)[i], crossed.row(40 + y)[6 + i]);
    EXPECT_EQ(read_image(path("d.exr")).pixels, mean(cropped).pixels);
    EXPECT_EQ(read_image(path("e.exr")).pixels, read_image(path("d.exr")).pixels);
  }
}

TEST_F(Pipeline, TakesPicturesFromMemoryAndKeepsThemThere) {
  auto image = std::make_shared<Image>(make_image(13, 101, {"R", "G", "B"}));
  const Image crossed = cross(2, "clamp")(*image), shuffled = mean(crossed);
  for (const int rows : {0, 7}) {
    RunRequest request;
    request.input = {"the input", {}, image};
    request.stages = {parse_stage("cross:radius=2")};
    request.keep_picture = true;
    request.strip_rows = rows;
    MetricRequest metric;
    metric.item = parse_metric("error");
    metric.reference = {"the reference", {}, std::make_shared<const Image>(crossed)};
    request.metrics = {metric};
    const RunResult once = run(request);
    ASSERT_TRUE(once.picture);
    EXPECT_EQ(once.picture->pixels, crossed.pixels) << rows;
    EXPECT_EQ(once.metrics[0].scores.at(3).value, 0);
    EXPECT_EQ(once.metrics[0].reference, "the reference");
    // What was kept is an input like any other; beside a file, and through a stage that holds the whole picture.
    request = {};
    request.input = {"kept", {}, once.picture};
    request.stages = {parse_stage("mean")};
    request.output = path("e.exr");
    request.write.depth = Depth::kFloat;
    request.keep_picture = true;
    EXPECT_EQ(run(request).picture->pixels, shuffled.pixels);
    EXPECT_EQ(read_image(path("e.exr")).pixels, shuffled.pixels);
  }
  EXPECT_EQ(fs::exists(path("the input")), false);
}

TEST_F(Pipeline, AlphaPassesByAndIsAveraged) {
  const Image image = make_image(12, 5, {"R", "G", "B", "A"});
  const std::string input = store("in.exr", image);
  const Image got = result(input, {"row-mean"}, 2, 2);
  ASSERT_EQ(got.spec.width, 4);
  ASSERT_EQ(got.spec.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 4; ++x) {
      const float* block = image.row(y) + x * 12;
      const double alpha = (static_cast<double>(block[3]) + block[7] + block[11]) / 3;
      EXPECT_FLOAT_EQ(got.row(y)[x * 4 + 3], static_cast<float>(alpha));
    }
}

TEST_F(Pipeline, ValuesThatAreNotFiniteStayInTheirRow) {
  Image image = make_image(12, 40, {"R", "G", "B"});
  image.row(7)[4] = std::numeric_limits<float>::quiet_NaN();
  image.row(21)[30] = -std::numeric_limits<float>::infinity();
  const std::string input = store("in.exr", image);
  const Image got = result(input, {"row-mean"}, 2, 4);
  for (const float value : got.pixels) EXPECT_TRUE(std::isfinite(value));
  // Without a stage that spreads them they pass.
  const Image kept = result(input, {"fives"}, 2, 4);
  EXPECT_TRUE(std::isnan(kept.row(7)[4]));
  EXPECT_EQ(kept.row(21)[30], -std::numeric_limits<float>::infinity());
}

TEST_F(Pipeline, NanPolicies) {
  Image image = make_image(5, 200, {"R", "G", "B"});
  image.row(150)[4] = std::numeric_limits<float>::quiet_NaN();
  RunRequest request;
  request.input.path = store("in.exr", image);
  request.output = path("out.exr");
  request.nan = NanPolicy::kFail;
  EXPECT_THROW(run(request), Error);
  EXPECT_FALSE(fs::exists(request.output));
  request.nan = NanPolicy::kZero;
  EXPECT_EQ(run(request).input_nonfinite.nan, 1u);
  EXPECT_EQ(read_image(request.output).row(150)[4], 0.0f);
}

struct Expected {
  double mean = 0, variance = 0;
};

Expected variance_of(const Image& a, const Image& b, const std::function<double(int, int)>& weight) {
  double sum = 0, total = 0, squares = 0;
  const auto d = [&](int x, int y) {
    return static_cast<double>(at(a, x, y + 1, 0, "clamp")) - at(b, x, y - 1, 0, "clamp");
  };
  for (int y = 0; y < a.spec.height; ++y)
    for (int x = 0; x < a.spec.width; ++x) sum += weight(x, y) * d(x, y), total += weight(x, y);
  for (int y = 0; y < a.spec.height; ++y)
    for (int x = 0; x < a.spec.width; ++x)
      squares += weight(x, y) * (d(x, y) - sum / total) * (d(x, y) - sum / total);
  return {sum / total, squares / total};
}

TEST_F(Pipeline, MetricsSeeFixedStripsInOrderWhateverTheCut) {
  const Image a = make_image(9, 200, {"Y"}), b = flip(a);
  RunRequest request;
  request.input.path = store("a.exr", a);
  MetricRequest metric;
  metric.item = parse_metric("variance@v");
  metric.reference.path = store("b.exr", b);
  request.metrics = {metric};
  const Expected whole = variance_of(a, b, [](int, int) { return 1; });
  std::vector<uint64_t> bits;
  for (const auto& [threads, rows] : std::vector<std::pair<int, int>>{{1, 0}, {2, 1}, {7, 3}, {2, 100}, {1, 1000}}) {
    set_thread_limit(threads);
    request.strip_rows = rows;
    request.metrics[0].map_path = path("map.exr");
    const RunResult got = run(request);
    ASSERT_EQ(got.metrics.size(), 1u);
    EXPECT_EQ(got.metrics[0].label, "v");
    EXPECT_NEAR(got.metrics[0].scores[0].value, whole.mean, 1e-12);
    EXPECT_NEAR(got.metrics[0].scores[1].value, whole.variance, 1e-12);
    EXPECT_EQ(got.metrics[0].scores[2].value, 4);  // 200 rows in strips of 64
    bits.push_back(std::bit_cast<uint64_t>(got.metrics[0].scores[1].value));
    const Image map = read_image(path("map.exr"));
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 9; ++x)
        EXPECT_NEAR(map.row(y)[x], at(a, x, y + 1, 0, "clamp") - at(b, x, y - 1, 0, "clamp"), 1e-3) << "half float";
  }
  EXPECT_THAT(bits, testing::Each(bits[0]));

  request.metrics[0].map_path.clear();
  request.crop = CropRequest{2, 70, 5, 11};
  const Expected cropped = variance_of(a, b, [](int x, int y) { return x >= 2 && x < 7 && y >= 70 && y < 81; });
  EXPECT_NEAR(run(request).metrics[0].scores[1].value, cropped.variance, 1e-12);

  const Image weights = make_image(9, 200, {"Y"});
  request.crop.reset();
  request.mask = store("mask.exr", weights);
  const Expected masked = variance_of(a, b, [&](int x, int y) { return weights.row(y)[x]; });
  EXPECT_NEAR(run(request).metrics[0].scores[1].value, masked.variance, 1e-12);
}

TEST_F(Pipeline, ComparisonsOverNanFailUnlessTold) {
  Image a = make_image(9, 100, {"Y"}), b = make_image(9, 100, {"Y"});
  b.row(3)[2] = 0.25f;
  a.row(50)[4] = std::numeric_limits<float>::quiet_NaN();
  a.row(70)[4] = std::numeric_limits<float>::infinity();
  b.row(10)[0] = std::numeric_limits<float>::quiet_NaN();
  RunRequest request;
  request.input.path = store("a.exr", a);
  MetricRequest metric;
  metric.item = parse_metric("error");
  metric.reference.path = store("b.exr", b);
  request.metrics = {metric};
  const MetricResult failed = run(request).metrics[0];
  EXPECT_TRUE(failed.nonfinite_failed);
  EXPECT_TRUE(failed.scores.empty());
  EXPECT_EQ(failed.nonfinite.nan, 2u);
  EXPECT_EQ(failed.nonfinite.inf, 1u);
  request.metric_nan = NanPolicy::kIgnore;
  const MetricResult ignored = run(request).metrics[0];
  EXPECT_EQ(ignored.scores[0].name, "bias");
  EXPECT_NEAR(ignored.scores[0].value, .75 * 0 + (static_cast<double>(a.row(3)[2]) - .25) / (900 - 3), 1e-12);
  request.metric_nan = NanPolicy::kZero;
  const double zeroed = ((static_cast<double>(a.row(3)[2]) - .25) - b.row(50)[4] - b.row(70)[4] + a.row(10)[0]) / 900;
  EXPECT_NEAR(run(request).metrics[0].scores[0].value, zeroed, 1e-12);
}

TEST_F(Pipeline, MemoryIsBoundedOrRefused) {
  const Image image = make_image(512, 2048, {"R", "G", "B"});
  RunRequest request;
  request.input.path = store("in.exr", image);
  request.stages = {parse_stage("cross:radius=1")};
  request.output = path("out.exr");
  PluginHost host({TRIAD_TEST_STAGES, TRIAD_BINARY_DIR "/plugins"});
  const ColourConfig colours = ColourConfig::load();
  const uint64_t wanted = triad::Run(request, host, colours).peak_memory();
  request.max_memory = 149u << 20;
  const uint64_t bounded = triad::Run(request, host, colours).peak_memory();
  EXPECT_LE(bounded, request.max_memory);
  EXPECT_LT(bounded, wanted);
  request.max_memory = 100u << 20;  // less than the program itself
  EXPECT_THROW(triad::Run(request, host, colours), Error);
  request.max_memory = 158u << 20;
  request.stages = {parse_stage("mean")};
  EXPECT_THROW(triad::Run(request, host, colours), Error);  // 12.6 MB twice
  // What a stage says that it allocates counts; the message says what would do.
  request.max_memory = 1u << 30;
  const uint64_t plain = triad::Run(request, host, colours).peak_memory();
  request.stages = {parse_stage("mean:work=100000000")};
  EXPECT_EQ(triad::Run(request, host, colours).peak_memory(), plain + 100000000);
  request.max_memory = plain + 99999999;
  const std::string enough = "--max-memory " + std::to_string(((plain + 100000000) >> 20) + 1) + "M would do";
  try {
    triad::Run(request, host, colours);
    ADD_FAILURE() << "a run beyond its memory was planned";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(enough));
  }
}

TEST_F(Pipeline, MetricsWhoseStripsDoNotFitTogetherAreRefused) {
  RunRequest request;
  request.input.path = store("in.exr", make_image(8, 12000, {"R", "G", "B"}));
  PluginHost host({TRIAD_TEST_STAGES, TRIAD_BINARY_DIR "/plugins"});
  const ColourConfig colours = ColourConfig::load();
  const auto message = [&](const std::vector<std::string>& metrics) -> std::string {
    request.metrics.clear();
    for (const std::string& metric : metrics) request.metrics.push_back({parse_stage(metric), request.input, ""});
    try {
      triad::Run(request, host, colours);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  using testing::AllOf, testing::HasSubstr;
  EXPECT_THAT(
      message({"variance:rows=128", "variance:rows=127", "variance:rows=64"}),
      AllOf(HasSubstr("'variance:rows=128' works in strips of 128 rows"),
            HasSubstr("'variance:rows=127' in strips of 127"), HasSubstr("12000"), HasSubstr("one at a time")));
  EXPECT_THAT(message({"variance:rows=128", "variance:rows=192", "variance:rows=4096"}),
              AllOf(HasSubstr("'variance:rows=192' works"), HasSubstr("'variance:rows=4096' in strips of 4096")));
  // One metric may have what strips it likes, and others that divide them.
  EXPECT_EQ(message({"variance:rows=6400", "variance:rows=64"}), "");
  EXPECT_EQ(message({"variance:rows=128", "variance:rows=192", "variance"}), "");
  // A picture that is lower than the common strip is worked on whole, as long as there is memory for that.
  request.input.path = store("in.exr", make_image(100, 4000, {"R", "G", "B"}));
  EXPECT_EQ(message({"variance:rows=127", "variance"}), "");
  request.max_memory = 150u << 20;
  EXPECT_THAT(message({"variance:rows=127", "variance"}),
              AllOf(HasSubstr("this chain needs"), HasSubstr("'variance:rows=127' works in strips of 127"),
                    HasSubstr("'variance' in strips of 64")));
}

TEST_F(Pipeline, APictureKeptBeforeACropIsNotHeldForIt) {
  const Image image = make_image(64, 20000, {"R", "G", "B"});
  for (const char* before : {"cross:radius=1", "running"}) {
    RunRequest request;
    request.input.path = store("in.exr", image);
    request.stages = {parse_stage(before), parse_stage("write:" + path("whole.exr")),
                      parse_stage("crop:y=19000,h=10")};
    request.output = path("part.exr");
    request.write.depth = Depth::kFloat;
    PluginHost host({TRIAD_TEST_STAGES, TRIAD_BINARY_DIR "/plugins"});
    const ColourConfig colours = ColourConfig::load();
    triad::Run work(request, host, colours);
    // A serial stage's result is kept instead of made twice: 15 MB.
    EXPECT_LT(work.peak_memory(), std::string(before) == "running" ? 180e6 : 164e6);
    work.execute();
    const Image whole = std::string(before) == "running" ? running(image) : cross(1, "clamp")(image);
    EXPECT_EQ(read_image(path("whole.exr")).pixels, whole.pixels);
    const Image part = read_image(path("part.exr"));
    EXPECT_TRUE(std::equal(part.pixels.begin(), part.pixels.end(), whole.row(19000)));
  }
}

TEST_F(Pipeline, OutputsDoNotDestroyWhatIsReadOrWritten) {
  const std::string input = store("in.exr", make_image(5, 5, {"R", "G", "B"}));
  const std::string reference = store("ref.exr", make_image(5, 5, {"R", "G", "B"}));
  const auto refused = [&](const std::string& output, const std::string& tap, const std::string& map) {
    RunRequest request;
    request.input.path = input;
    request.output = output;
    if (!tap.empty()) request.stages = {parse_stage("write:" + tap)};
    MetricRequest metric;
    metric.item = parse_metric("error");
    metric.reference.path = reference;
    metric.map_path = map;
    request.metrics = {metric};
    PluginHost host({TRIAD_BINARY_DIR "/plugins"});
    const ColourConfig colours = ColourConfig::load();
    try {
      triad::Run(request, host, colours);
      return false;
    } catch (const Error&) {
      return true;
    }
  };
  const std::string folder = folder_;
  EXPECT_TRUE(refused(reference, "", ""));
  EXPECT_TRUE(refused("", "", folder + "/./ref.exr"));
  EXPECT_TRUE(refused("", "", folder + "/./in.exr"));
  EXPECT_TRUE(refused(folder + "/a.exr", folder + "/../" + folder_.filename().string() + "/a.exr", ""));
  EXPECT_TRUE(refused(folder + "/a.exr", "", folder + "//a.exr"));
  EXPECT_FALSE(refused(input, "", folder + "/map.exr")) << "in place is allowed";
}

TEST_F(Pipeline, NanOutsideThePoolingDoesNotFailAComparison) {
  Image a = make_image(9, 100, {"R", "G", "B"});
  const std::string reference = store("b.exr", a);
  a.row(50)[4] = std::numeric_limits<float>::quiet_NaN();
  RunRequest request;
  request.input.path = store("a.exr", a);
  MetricRequest metric;
  metric.item = parse_metric("error");
  metric.reference.path = reference;
  request.metrics = {metric};
  request.crop = CropRequest{0, 0, 9, 50};
  const MetricResult outside = run(request).metrics[0];
  EXPECT_FALSE(outside.nonfinite_failed);
  EXPECT_EQ(outside.scores.at(3).value, 0);
  request.crop = CropRequest{0, 0, 9, 51};
  EXPECT_TRUE(run(request).metrics[0].nonfinite_failed);
}

TEST_F(Pipeline, RefusesWhatDoesNotFit) {
  const std::string input = store("in.exr", make_image(5, 5, {"R", "G", "B"}));
  RunRequest request;
  request.input.path = input;
  request.output = path("none/out.exr");
  EXPECT_THROW(run(request), Error);
  request.output = path("out.exr");
  request.stages = {parse_stage("write:" + path("out.exr"))};
  EXPECT_THROW(run(request), Error);
  request.stages = {parse_stage("variance")};
  EXPECT_THROW(run(request), Error);
  request.stages = {parse_stage("crop:x=3,y=3,w=3,h=3")};
  EXPECT_THROW(run(request), Error);
  EXPECT_FALSE(fs::exists(path("out.exr")));
}

}  // namespace
