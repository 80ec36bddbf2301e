// SPDX-License-Identifier: Apache-2.0
// The options of triad render, and what they come to.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <triad/image/writer.hpp>
#include <triad/sampling/render.hpp>

#include "options.hpp"
#include "render_chain.hpp"
#include "render_source.hpp"

namespace triad::app {

constexpr int64_t kMostForUntil = 1 << 16;  // samples per pixel that --until may take when --spp does not say

struct RenderVerbOptions {
  std::string source, output, size, strategy, cells, effects, planes, until, camera, from, json, depth, compression,
      chain;
  HostOptions host;
  std::optional<int64_t> spp;
  std::optional<int> bounces;
  std::string seed = "0";
  int threads = 0;
};

struct RenderJob {
  PictureSize picture, film;
  PictureSize written;  // the film's, but for a chain that changes it
  Cells cells;
  std::string layout;  // whose cells these are; "" none
  RenderOptions render;
  std::unique_ptr<Strategy> strategy;
  SourceRequest source;
  WriteOptions write;
  RenderChain chain;
  bool display_encoded = false;
};

// Whether any of the planes tells of more than colour and samples.
bool has_geometry(const FilmPlanes& planes);

// Everything that the command line says, checked before any file but the output is touched. Throws Error(kUsage) and,
// for an output that cannot be written, Error(kInput).
RenderJob check_render(const RenderVerbOptions& options);

}  // namespace triad::app
