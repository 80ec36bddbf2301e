// SPDX-License-Identifier: Apache-2.0
#include "render_job.hpp"

#include <charconv>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>

namespace triad::app {
namespace {

// Options that the kind of source has no use for are mistakes.
void check_source_options(const RenderVerbOptions& options, const Strategy& strategy) {
  const SourceKind kind = source_kind(options.source);
  const std::string what = kind == SourceKind::kScene      ? "a scene"
                           : kind == SourceKind::kFunction ? "a function"
                                                           : "a picture";
  const auto refuse = [&](bool given, const std::string& option, const std::string& owner) {
    if (given)
      throw_usage(option + " is for " + owner + ", and '" + options.source + "' is " + what + "; leave it out");
  };
  if (kind != SourceKind::kScene) {
    refuse(!options.camera.empty(), "--camera", "scenes");
    refuse(!options.effects.empty(), "--effects", "scenes");
    refuse(options.bounces.has_value(), "--bounces", "scenes");
  }
  if (kind == SourceKind::kScene && strategy.info().name == "exact")
    throw_usage("--strategy exact is for functions and pictures, and '" + options.source +
                "' is a scene; take many samples, or --until");
  if (kind != SourceKind::kPicture) refuse(!options.from.empty(), "--from", "pictures");
}

// What it reads and writes besides its record.
std::vector<std::string> files_of(const RenderVerbOptions& options) {
  std::vector<std::string> files{options.output};
  if (source_kind(options.source) != SourceKind::kFunction) files.push_back(options.source);
  if (options.chain.ends_with(".toml")) files.push_back(options.chain);
  if (options.cells.ends_with(".toml")) files.push_back(options.cells);
  return files;
}

std::unique_ptr<Strategy> choose_strategy(const RenderVerbOptions& options) {
  if (!options.strategy.empty()) {
    if (options.spp)
      throw_usage("--spp is short for --strategy sobol-owen:spp=" + std::to_string(*options.spp) +
                  "; give it or --strategy, not both");
    return make_strategy(options.strategy, "--strategy");
  }
  if (options.spp) return make_strategy("sobol-owen:spp=" + std::to_string(*options.spp), "--spp");
  if (!options.until.empty()) return make_strategy("sobol-owen:spp=" + std::to_string(kMostForUntil), "--until");
  return make_strategy("sobol-owen", "--strategy");
}

}  // namespace

bool has_geometry(const FilmPlanes& planes) {
  return planes.depth || planes.position || planes.normal || planes.albedo || planes.object_id || planes.material_id;
}

RenderJob check_render(const RenderVerbOptions& options) {
  RenderJob job;
  job.picture = parse_size(options.size, "--size");
  if (!options.cells.empty()) {
    const CellsOfLayout chosen = parse_cells_or_layout(options.cells, "--cells");
    job.cells = chosen.cells;
    job.layout = chosen.layout;
  }
  job.film = film_size(job.picture, job.cells);
  job.strategy = choose_strategy(options);
  check_source_options(options, *job.strategy);
  const char* const seed_end = options.seed.data() + options.seed.size();
  const auto [seed_rest, seed_error] = std::from_chars(options.seed.data(), seed_end, job.render.seed);
  if (seed_error != std::errc{} || seed_rest != seed_end)
    throw_usage("--seed '" + printable(options.seed) + "' cannot be used; it must be a whole number from 0 to " +
                std::to_string(std::numeric_limits<uint64_t>::max()));
  job.render.cells = job.cells;
  job.render.planes = parse_planes(options.planes, "--aov");
  if (!options.until.empty()) job.render.until_rmse = parse_until(options.until, "--until");
  if (job.render.until_rmse > 0 && !job.strategy->estimates_error())
    throw_usage("--until needs random samples, from which an error can be estimated, and '" + job.strategy->text() +
                "' has no independent samples in each pixel; take sobol-owen");
  job.render.planes.error = job.strategy->estimates_error() && (!options.until.empty() || !options.json.empty());

  job.write.depth = options.depth.empty() ? Depth::kDefault : parse_depth(options.depth);
  job.write.compression = options.compression;
  job.display_encoded = is_display_encoded_format(options.output, job.write.depth);
  // Half is too coarse for ids, and its steps of 2^-11 are as large as the errors that people measure here.
  if (options.depth.empty() && lower(options.output).ends_with(".exr")) job.write.depth = Depth::kFloat;
  if (!options.planes.empty() && !lower(options.output).ends_with(".exr"))
    throw_usage("--aov needs a file that holds further channels, and '" + options.output +
                "' does not; write an .exr");
  require_film_memory(job.film.width, job.film.height, job.render.planes);
  check_report_file("--json", options.json, files_of(options));
  // Whether it can be written at all shall not come out after hours; what is not committed leaves nothing behind.
  ImageSpec spec = render_spec(job.film, job.cells, job.render.planes, *job.strategy);
  if (options.chain.empty()) {
    ImageWriter::open(options.output, spec, job.write);
  } else {
    if (!options.planes.empty())
      throw_usage(
          "--aov keeps channels of the render, and --chain makes another picture of it; leave one of them out");
    job.chain = RenderChain(options.chain, options.host.plugin_path);
    if (!job.layout.empty()) spec.metadata.set("triad:layout", job.layout);
    spec = job.chain.check(spec, options.output, job.write);
  }
  job.written = {spec.width, spec.height};

  const FilmPlanes& planes = job.render.planes;
  job.source = {.name = options.source,
                .picture = job.picture,
                .cells = job.cells,
                .geometry = job.strategy->uses_geometry() || has_geometry(planes),
                .camera = options.camera,
                .effects = options.effects,
                .bounces = options.bounces.value_or(SourceRequest{}.bounces),
                .colour_space = options.from};
  return job;
}

}  // namespace triad::app
