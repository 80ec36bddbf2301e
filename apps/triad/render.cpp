// SPDX-License-Identifier: Apache-2.0
// triad render SOURCE -o OUT --size WxH
#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>

#include "render_job.hpp"
#include "stopwatch.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostThreads = 1024;
constexpr int kMostBounces = 1000;

struct Seconds {
  double load = 0, build = 0, render = 0, chain = 0, write = 0;
};

void write_picture(const std::string& path, Image image, const RenderJob& job) {
  if (job.display_encoded) {
    const ColourConfig colours = ColourConfig::load();
    colours.transform(colours.lin_rec709(), colours.srgb())
        .apply(image.pixels.data(), image.pixels.size() / image.spec.channels.size(), image.spec.channel_count(), -1);
    image.spec.colour_space = colours.srgb();
    image.spec.chromaticities.reset();
  }
  write_image(path, image, job.write);
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string record(const RenderVerbOptions& options, const RenderJob& job, const OpenedSource& opened,
                   const RenderResult& result, const Seconds& seconds) {
  Json root = opened.record;
  root["output"] = options.output;
  root["size"] = {job.picture.width, job.picture.height};
  root["cells"] = {job.cells.x, job.cells.y};
  root["layout"] = job.layout.empty() ? Json(nullptr) : Json(job.layout);
  root["strategy"] = job.strategy->text();
  root["chain"] = job.chain.empty() ? Json(nullptr) : Json(job.chain.text());
  root["seed"] = job.render.seed;
  root["threads"] = thread_limit();
  root["complete"] = result.complete;
  root["samples"] = result.samples;
  root["dropped"] = result.dropped;
  root["rmse"] = number(result.passes.empty() ? NAN : result.passes.back().rmse);
  root["until_reached"] = options.until.empty() ? Json(nullptr) : Json(result.reached);
  root["work"] = Json::object();
  for (const WorkCount& work : opened.source->work()) root["work"][work.kind] = work.count;
  root["seconds"] = {{"load", seconds.load},
                     {"build", seconds.build},
                     {"render", seconds.render},
                     {"chain", seconds.chain},
                     {"write", seconds.write}};
  root["passes"] = Json::array();
  for (const PassRecord& pass : result.passes)
    root["passes"].push_back({{"samples", pass.samples}, {"seconds", pass.seconds}, {"rmse", number(pass.rmse)}});
  return json_text(std::move(root), 2);
}

void tell(const RenderVerbOptions& options, const RenderJob& job, const RenderResult& result) {
  if (result.dropped > 0)
    warn(fmt::format("{} of {} samples were not finite and are left out, the first in pixel {},{}", result.dropped,
                     result.samples, result.dropped_x, result.dropped_y));
  const double rmse = result.passes.empty() ? NAN : result.passes.back().rmse;
  if (!options.until.empty() && result.complete && !result.reached)
    warn(fmt::format(
        "{} ends with an estimated rmse of {:.3g}; --until {} takes more samples, see --spp and --strategy",
        job.strategy->text(), rmse, options.until));
  if (!result.complete) {
    const double pixels = static_cast<double>(job.film.width) * job.film.height;
    std::cerr << fmt::format(
        "triad: interrupted: '{}' holds what was done, {:.3g} samples per pixel, and is marked partial\n",
        printable(options.output), static_cast<double>(result.samples) / pixels);
    g_exit_status = Error(ErrorKind::kCancelled, "").exit_status();
  }
}

void render(const RenderVerbOptions& options) {
  if (options.threads > 0) set_thread_limit(options.threads);
  RenderJob job = check_render(options);
  const OpenedSource opened = open_source(job.source, "SOURCE");
  const Source& source = *opened.source;
  if (const auto missing = missing_planes(job.render.planes, source.abilities()); !missing.empty())
    throw_usage("--aov " + options.planes + ": '" + options.source + "' does not tell " + join(missing, ", ") +
                "; leave that out");
  Seconds seconds{.load = opened.load_s, .build = opened.build_s};
  Stopwatch watch;
  if (options.json != "-" && !opened.summary.empty()) std::cout << opened.summary << std::endl;

  job.render.stop = cancel_requested;
  const RenderResult result = [&] {
    Progress progress(options.output);
    job.render.progress = [&](double done) { progress.update(done); };
    return job.strategy->render(source, job.render);
  }();
  if (result.samples == 0) check_cancel();  // there is nothing to keep
  seconds.render = watch.lap();

  Facts facts = opened.facts;
  if (!job.layout.empty()) facts.emplace_back("layout", job.layout);
  Image picture = render_picture(result, *job.strategy, job.render, source, job.cells, facts);
  if (job.chain.empty()) {
    write_picture(options.output, std::move(picture), job);
  } else {
    seconds.chain = job.chain.write(std::move(picture), options.source, options.output, job.write);
  }
  seconds.write = watch.lap() - seconds.chain;
  if (options.json != "-")
    std::cout << fmt::format("{}: {}x{}, {}, {} samples in {:.2f} s\n", printable(options.output), job.written.width,
                             job.written.height, job.strategy->text(), result.samples, seconds.render);
  if (!options.json.empty()) write_text_file(options.json, record(options, job, opened, result, seconds));
  tell(options, job, result);
}

}  // namespace

void setup_render(CLI::App& app) {
  auto options = std::make_shared<RenderVerbOptions>();
  CLI::App* verb =
      app.add_subcommand("render", "Draw a scene, function or picture: standard, wide, or as ground truth");
  verb->add_option("source", options->source,
                   "A bundled scene's name, a function as in checker:cell=3.7, a glTF 2.0 file, .gltf or .glb, or a "
                   "picture to sample anew, at least as large as the output")
      ->required()
      ->type_name("SOURCE");
  verb->add_option("-o,--output", options->output, "The picture to write; EXR keeps linear light and its facts")
      ->required()
      ->type_name("OUT");
  verb->add_option("--size", options->size, "Width and height in display pixels")->required()->type_name("WxH");
  verb->add_option("--spp", options->spp, "Samples per pixel: short for --strategy sobol-owen:spp=N (default: 16)")
      ->type_name("N");
  verb->add_option("--strategy", options->strategy, "Where samples lie: name:key=value; see triad list strategies")
      ->type_name("S");
  verb->add_option(
          "--until", options->until,
          fmt::format("Stop once the estimated error is reached; takes at most --spp or what --strategy takes, "
                      "or {} without either",
                      kMostForUntil))
      ->type_name("rmse=V");
  verb->add_option("--cells", options->cells,
                   "Fine cells per display pixel, as in 3x1, or a layout's name or path (see triad list layouts): a "
                   "wide render of the same view")
      ->type_name("XxY");
  verb->add_option("--chain", options->chain,
                   "Filters that the render goes through before it is written: stages as for triad run, or a chain's "
                   "file")
      ->type_name("STAGES")
      ->check(not_empty());
  options->host.add_plugin_path(*verb);
  verb->add_option("--camera", options->camera, "A camera's name, or number from 0 (default: the scene's first)")
      ->type_name("NAME");
  verb->add_option("--effects", options->effects,
                   "What to draw: names with commas, all or none (default: what the scene calls for)")
      ->type_name("LIST");
  verb->add_option("--bounces", options->bounces,
                   fmt::format("Times that a path of light may be scattered after its first surface (default: {})",
                               SourceRequest{}.bounces))
      ->type_name("N")
      ->check(CLI::Range(0, kMostBounces));
  verb->add_option("--from", options->from, "A picture's colour space (default: what the file says)")
      ->type_name("SPACE")
      ->check(not_empty());
  verb->add_option("--aov", options->planes, "Further channels: " + join(plane_names(), ", "))->type_name("LIST");
  verb->add_option("--seed", options->seed, "Another seed, other noise")->type_name("S")->capture_default_str();
  verb->add_option("--threads", options->threads, "Threads (default: all cores); never changes the picture")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads));
  verb->add_option("--depth", options->depth, "Stored type: 8, 16, half or float (default: float for EXR)")
      ->type_name("D");
  verb->add_option("--compression", options->compression, "Compression of the output: none, zip, piz ...")
      ->type_name("C");
  verb->add_option("--json", options->json, "Write samples, rays, errors and seconds as JSON; - for standard output")
      ->type_name("FILE");
  verb->footer(
      "Examples:\n"
      "  triad render cornell -o cornell.exr --size 400x225 --spp 64\n"
      "  triad render house.glb -o wide.exr --size 1200x675 --spp 64 --cells 3x1\n"
      "  triad render house.glb -o oled.exr --size 1200x675 --spp 64 --cells qd-oled\n"
      "  triad render house.glb -o house.png --size 1200x675 --strategy cells --cells rgb --chain platt:ppd=40\n"
      "  triad render house.glb -o truth.exr --size 1200x675 --until rmse=1e-3 --json truth.json\n"
      "  triad render house.glb -o edges.exr --size 1200x675 --strategy grid:n=4 --aov depth,normal\n"
      "  triad render zone-plate -o zone.exr --size 400x400 --strategy grid:n=4\n"
      "  triad render checker:cell=3.7,angle=12 -o truth.exr --size 400x225 --strategy exact\n"
      "  triad render big.exr -o small.exr --size 400x225 --strategy quad\n"
      "Ctrl-C writes what is done so far, marks it triad:partial, and exits with 130; with --chain or --strategy "
      "exact it writes nothing.\n"
      "See also: triad list scenes, triad list functions, triad list strategies, triad help sobol-owen, triad help "
      "checker");
  verb->callback([options] { render(*options); });
}

}  // namespace triad::app
