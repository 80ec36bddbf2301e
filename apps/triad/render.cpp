// SPDX-License-Identifier: Apache-2.0
// triad render SCENE -o OUT --size WxH
#include <fmt/format.h>
#include <charconv>
#include <raytracer/gltf_loader.hpp>
#include <raytracer/scene_source.hpp>

#include <chrono>
#include <cmath>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/image/writer.hpp>
#include <triad/sampling/render.hpp>

#include "bundled_scenes.hpp"
#include "options.hpp"
#include "render_chain.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostThreads = 1024;
constexpr int64_t kMostForUntil = 1 << 16;  // samples per pixel that --until may take when --spp does not say
constexpr int kMostBounces = 1000;

struct Options {
  std::string scene, output, size, strategy, cells, effects, planes, until, camera, json, depth, compression, chain;
  HostOptions host;
  std::optional<int64_t> spp;
  std::string seed = "0";
  int threads = 0, bounces = 32;
};

// Everything that the command line says, checked before any file but the output is touched.
struct Job {
  PictureSize picture, film;
  Cells cells;
  std::string layout;  // whose cells these are; "" none
  RenderOptions render;
  std::unique_ptr<Strategy> strategy;
  raytracer::SourceOptions source;
  WriteOptions write;
  RenderChain chain;
  bool display_encoded = false;
};

struct Seconds {
  double load = 0, build = 0, render = 0, chain = 0, write = 0;
};

// Seconds since the last call, or since it was made.
class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

std::unique_ptr<Strategy> choose_strategy(const Options& options) {
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

Job check(const Options& options) {
  Job job;
  job.picture = parse_size(options.size, "--size");
  if (!options.cells.empty()) {
    const CellsOfLayout chosen = parse_cells_or_layout(options.cells, "--cells");
    job.cells = chosen.cells;
    job.layout = chosen.layout;
  }
  job.film = film_size(job.picture, job.cells);
  job.strategy = choose_strategy(options);
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
  // Whether it can be written at all shall not come out after hours; what is not committed leaves nothing behind.
  const ImageSpec spec = render_spec(job.film, job.cells, job.render.planes, *job.strategy);
  ImageWriter::open(options.output, spec, job.write);
  if (!options.chain.empty()) {
    if (!options.planes.empty())
      throw_usage(
          "--aov keeps channels of the render, and --chain makes another picture of it; leave one of them out");
    job.chain = RenderChain(options.chain, options.host.plugin_path);
    ImageSpec named = spec;
    if (!job.layout.empty()) named.metadata.set("triad:layout", job.layout);
    job.chain.check(named, options.output, job.write);
  }

  job.source.width = job.film.width;
  job.source.height = job.film.height;
  const FilmPlanes& planes = job.render.planes;
  job.source.geometry = job.strategy->uses_geometry() || planes.depth || planes.position || planes.normal ||
                        planes.albedo || planes.object_id || planes.material_id;
  job.source.picture_aspect = static_cast<double>(job.picture.width) / job.picture.height;
  if (!options.effects.empty()) job.source.effects = raytracer::parse_effects(options.effects);
  job.source.max_depth = options.bounces;
  return job;
}

// A bar that any thread may move.
class SharedProgress {
 public:
  explicit SharedProgress(const std::string& what) : progress_(what) {}
  void update(double done) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock) progress_.update(done);
  }

 private:
  std::mutex mutex_;
  Progress progress_;
};

std::shared_ptr<const raytracer::Scene> load(const Options& options) {
  Progress progress("loading " + options.scene);
  const auto update = [&progress](double done) { progress.update(done); };
  return std::make_shared<const raytracer::Scene>(
      raytracer::load_gltf(scene_file(options.scene), {options.camera, update}));
}

std::unique_ptr<raytracer::SceneSource> build(std::shared_ptr<const raytracer::Scene> scene, Job& job) {
  SharedProgress progress("building " + scene->file);
  job.source.camera = scene->camera;
  job.source.build_progress_user = &progress;
  job.source.build_progress = [](void* user, double done) {
    static_cast<SharedProgress*>(user)->update(done);
    return !cancel_requested();
  };
  return raytracer::make_scene_source(std::move(scene), job.source);
}

std::string camera_name(const raytracer::Scene& scene) {
  const std::string& name = scene.cameras[static_cast<size_t>(scene.camera)].name;
  return name.empty() ? std::to_string(scene.camera) : name;
}

void write_picture(const std::string& path, Image image, const Job& job) {
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

std::string record(const Options& options, const Job& job, const raytracer::SceneSource& source,
                   const raytracer::Scene& scene, const RenderResult& result, const Seconds& seconds) {
  Json root;
  root["scene"] = options.scene;
  root["camera"] = camera_name(scene);
  root["output"] = options.output;
  root["size"] = {job.picture.width, job.picture.height};
  root["cells"] = {job.cells.x, job.cells.y};
  root["layout"] = job.layout.empty() ? Json(nullptr) : Json(job.layout);
  root["strategy"] = job.strategy->text();
  root["chain"] = job.chain.empty() ? Json(nullptr) : Json(job.chain.text());
  root["seed"] = job.render.seed;
  root["effects"] = raytracer::effects_text(source.effects());
  root["kernel"] = raytracer::effects_text(source.kernel_effects());
  root["triangles"] = scene.triangle_count();
  root["memory_bytes"] = source.memory_bytes();
  root["threads"] = thread_limit();
  root["complete"] = result.complete;
  root["samples"] = result.samples;
  root["dropped"] = result.dropped;
  root["rmse"] = number(result.passes.empty() ? NAN : result.passes.back().rmse);
  root["until_reached"] = options.until.empty() ? Json(nullptr) : Json(result.reached);
  root["work"] = Json::object();
  for (const WorkCount& work : source.work()) root["work"][work.kind] = work.count;
  root["seconds"] = {{"load", seconds.load},
                     {"build", seconds.build},
                     {"render", seconds.render},
                     {"chain", seconds.chain},
                     {"write", seconds.write}};
  root["passes"] = Json::array();
  for (const PassRecord& pass : result.passes)
    root["passes"].push_back({{"samples", pass.samples}, {"seconds", pass.seconds}, {"rmse", number(pass.rmse)}});
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void tell(const Options& options, const Job& job, const RenderResult& result) {
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

void render(const Options& options) {
  if (options.threads > 0) set_thread_limit(options.threads);
  Job job = check(options);
  Seconds seconds;
  Stopwatch watch;
  const auto scene = load(options);
  for (const std::string& line : scene->warnings) warn(line);
  check_cancel();
  seconds.load = watch.lap();
  const auto source = build(scene, job);
  for (const std::string& line : source->analysis().warnings) warn(line);
  seconds.build = watch.lap();
  if (options.json != "-") std::cout << source->analysis().text() << std::endl;

  job.render.stop = cancel_requested;
  const RenderResult result = [&] {
    Progress progress(options.output);
    job.render.progress = [&](double done) { progress.update(done); };
    return job.strategy->render(*source, job.render);
  }();
  if (result.samples == 0) check_cancel();  // there is nothing to keep
  seconds.render = watch.lap();

  Facts facts{{"scene", options.scene},
              {"camera", camera_name(*scene)},
              {"effects", raytracer::effects_text(source->effects())},
              {"bounces", std::to_string(options.bounces)}};
  if (!job.layout.empty()) facts.emplace_back("layout", job.layout);
  Image picture = render_picture(result, *job.strategy, job.render, *source, job.cells, facts);
  if (job.chain.empty()) {
    write_picture(options.output, std::move(picture), job);
  } else {
    seconds.chain = job.chain.write(std::move(picture), options.scene, options.output, job.write);
  }
  seconds.write = watch.lap() - seconds.chain;
  if (options.json != "-")
    std::cout << fmt::format("{}: {}x{}, {}, {} samples in {:.2f} s\n", printable(options.output), job.film.width,
                             job.film.height, job.strategy->text(), result.samples, seconds.render);
  if (!options.json.empty()) write_text_file(options.json, record(options, job, *source, *scene, result, seconds));
  tell(options, job, result);
}

}  // namespace

void setup_render(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("render", "Draw a glTF scene: standard, wide, or as ground truth");
  verb->add_option("scene", options->scene, "A glTF 2.0 file, .gltf or .glb, or a bundled scene's name")
      ->required()
      ->type_name("SCENE");
  verb->add_option("-o,--output", options->output, "The picture to write; EXR keeps linear light and its facts")
      ->required()
      ->type_name("OUT");
  verb->add_option("--size", options->size, "Width and height in display pixels")->required()->type_name("WxH");
  verb->add_option("--spp", options->spp, "Samples per pixel: short for --strategy sobol-owen:spp=N (default: 16)")
      ->type_name("N");
  verb->add_option("--strategy", options->strategy, "Where samples lie: name:key=value; see triad list strategies")
      ->type_name("S");
  verb->add_option("--until", options->until,
                   fmt::format("Stop once the estimated error is reached; takes at most --spp, or {}", kMostForUntil))
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
                   "Times that a path of light may be scattered after its first surface")
      ->type_name("N")
      ->check(CLI::Range(0, kMostBounces))
      ->capture_default_str();
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
      "Ctrl-C writes what is done so far, marks it triad:partial, and exits with 130; with --chain it writes "
      "nothing.\n"
      "See also: triad list scenes, triad list strategies, triad help sobol-owen, triad help variance");
  verb->callback([options] { render(*options); });
}

}  // namespace triad::app
