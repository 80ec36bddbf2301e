// SPDX-License-Identifier: Apache-2.0
// Runs a bundled stage through the host's own guard, over pictures in memory cut into strips.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <triad/base/error.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <vector>

#include "display_reference.hpp"

namespace stage_runner {

using triad::ParamTexts;

inline triad::PluginHost& host() {
  static triad::PluginHost instance = [] {
    setenv("TRIAD_DATA", TRIAD_SOURCE_DIR "/data", 1);
    return triad::PluginHost({TRIAD_BINARY_DIR "/plugins"});
  }();
  return instance;
}

inline triad_image header(int width, int height, int cells_x, int cells_y = 1) {
  triad_image image{};
  image.struct_size = sizeof image;
  image.width = width;
  image.height = height;
  image.channels = 3;
  image.alpha = -1;
  image.cells_x = cells_x;
  image.cells_y = cells_y;
  image.pixel_aspect = static_cast<double>(cells_y) / cells_x;
  std::copy(triad::reference::kRec709ToXyz.begin(), triad::reference::kRec709ToXyz.end(), image.rgb_to_xyz);
  return image;
}

struct Picture {
  triad_image image;
  std::vector<float> pixels;
  triad::Metadata metadata{};
};

inline Picture noise(int width, int height, int cells_x, unsigned seed, float low = 0, float high = 1,
                     int cells_y = 1) {
  Picture out{header(width, height, cells_x, cells_y), {}, {}};
  for (const double v : triad::reference::random_cells(width * height, seed))
    out.pixels.push_back(low + (high - low) * static_cast<float>(v));
  return out;
}

// The rectangle of a picture as a strip; what lies outside comes from the edge mode.
struct Strip {
  std::vector<float> data;
  triad_strip strip{};
  Strip(const Picture& picture, triad_rect r, int edge) {
    const auto inside = [&](int i, int size) {
      if (edge == TRIAD_EDGE_CLAMP) return std::clamp(i, 0, size - 1);
      if (edge == TRIAD_EDGE_ZERO) return i >= 0 && i < size ? i : -1;
      const int period = edge == TRIAD_EDGE_MIRROR ? 2 * size : size;
      const int k = ((i % period) + period) % period;
      return k < size ? k : 2 * size - 1 - k;
    };
    const int channels = picture.image.channels;
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x) {
        const int from_x = inside(x, picture.image.width), from_y = inside(y, picture.image.height);
        if (from_x < 0 || from_y < 0) {
          data.insert(data.end(), static_cast<size_t>(channels), 0.f);
          continue;
        }
        const auto at = (static_cast<size_t>(from_y) * picture.image.width + from_x) * channels;
        data.insert(data.end(), &picture.pixels[at], &picture.pixels[at] + channels);
      }
    strip = {sizeof strip, channels, r, data.data(), int64_t{r.x1 - r.x0} * channels * 4};
  }
};

struct Outcome {
  Picture out;
  std::vector<double> scores;
  std::map<std::string, double> reports;
  triad::StageReports all_reports{};  // series as well
};

// Runs a stage over pictures cut into strips of `rows` rows, merging in order.
inline Outcome run(const std::string& id, const ParamTexts& parameters, const std::vector<const Picture*>& pictures,
                   int rows = 1) {
  triad::StageInstance stage(host().find(id), parameters);
  std::vector<const triad_image*> images;
  for (const Picture* picture : pictures) images.push_back(picture ? &picture->image : nullptr);
  std::vector<const triad::Metadata*> metadata;
  for (const Picture* picture : pictures) metadata.push_back(picture ? &picture->metadata : nullptr);
  const auto plan = stage.plan(images, metadata);
  Outcome outcome{{plan.out, {}, plan.metadata}, {}, {}};
  if (plan.plan.strip_rows < 0) rows = INT32_MAX / 2;
  const triad_image& shape = stage.info().is_metric() ? *images[0] : plan.out;
  const int channels = plan.out.channels;
  outcome.out.pixels.resize(static_cast<size_t>(shape.width) * shape.height * channels);
  for (int pass = 0; pass < plan.plan.passes; ++pass) {
    std::vector<std::byte> total(plan.plan.state_bytes), state(plan.plan.state_bytes);
    for (int y = 0; y < shape.height; y += rows) {
      const triad_rect r{0, y, shape.width, std::min(y + rows, shape.height)};
      const auto needs = stage.need(pass, r);
      std::vector<Strip> strips;
      strips.reserve(pictures.size());
      std::vector<const triad_strip*> in;
      for (size_t i = 0; i < pictures.size(); ++i)
        if (pictures[i]) {
          strips.emplace_back(*pictures[i], needs[i], plan.plan.edge);
          in.push_back(&strips.back().strip);
        } else {
          in.push_back(nullptr);
        }
      const triad_strip out{sizeof out, channels, r,
                            outcome.out.pixels.data() + static_cast<size_t>(y) * shape.width * channels,
                            int64_t{shape.width} * channels * 4};
      std::fill(state.begin(), state.end(), std::byte{});
      stage.strip(pass, r, in, pass + 1 == plan.plan.passes ? &out : nullptr, state.data());
      if (!state.empty()) stage.merge(pass, total.data(), state.data());
    }
    outcome.scores = stage.end_pass(pass, total.data());
  }
  outcome.reports = stage.reports().values;
  outcome.all_reports = stage.reports();
  return outcome;
}

inline std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace stage_runner
