// SPDX-License-Identifier: Apache-2.0
// The ray tracer as a whole: what must be the same to the last bit, what is counted, and what must not break.
#include <gtest/gtest.h>

#include <cstring>

#include "raytracer/camera.hpp"
#include "raytracer_scenes.hpp"

namespace triad::raytracer::testing {
namespace {

bool same_bits(const std::vector<Sample>& a, const std::vector<Sample>& b) {
  for (size_t i = 0; i < a.size(); ++i)
    if (std::memcmp(a[i].rgb.data(), b[i].rgb.data(), sizeof(a[i].rgb)) != 0 ||
        std::memcmp(&a[i].distance, &b[i].distance, sizeof(float)) != 0 || a[i].normal != b[i].normal ||
        a[i].object_id != b[i].object_id)
      return false;
  return a.size() == b.size();
}

struct NamedScene {
  std::string name;
  Scene scene;
};

std::vector<NamedScene> all_kinds() {
  std::vector<NamedScene> kinds;
  kinds.push_back({"matt", box(matt({.5f, .5f, .5f}), matt({.2f, .3f, .9f}))});
  kinds.push_back({"mirror", box(metal({.9f, .8f, .5f}, 0), matt({.5f, .5f, .5f}))});
  kinds.push_back({"glossy", box(metal({.9f, .8f, .5f}, .3f), coated({.5f, .1f, .1f}, .2f))});
  kinds.push_back({"glass", box(glass(1.5f), matt({.5f, .5f, .5f}))});
  kinds.push_back({"mirror coat", box(coated({.5f, .1f, .1f}, 0), matt({.5f, .5f, .5f}))});
  Scene points = box(matt({.5f, .5f, .5f}), matt({.2f, .3f, .9f}));
  points.materials[3].emission = {};
  points.lights.push_back({"bulb", LightKind::kPoint, {0, .5f, 0}, {}, {1, 1, 1}});
  points.lights.push_back({"torch", LightKind::kSpot, {.5f, .9f, .5f}, {0, -1, 0}, {2, 2, 2}, .2f, .5f});
  points.lights.push_back({"sun", LightKind::kDirectional, {}, {0, -.6f, -.8f}, {1, 1, 1}});
  kinds.push_back({"point lights", std::move(points)});
  Scene outdoors = box(metal({.9f, .8f, .5f}, .3f), matt({.5f, .5f, .5f}));
  outdoors.environment.radiance = {.4f, .5f, .8f};
  kinds.push_back({"background", outdoors});
  Texture sky{"sky", 16, 8, 3, std::vector<float>(16 * 8 * 3, .2f)};
  for (int i = 0; i < 3; ++i) sky.texels[(2 * 16 + 9) * 3 + i] = 60;
  outdoors.textures.push_back(sky);
  outdoors.environment.texture = 0;
  kinds.push_back({"environment image", outdoors});
  Scene pictures = box(matt({.5f, .5f, .5f}), matt({1, 1, 1}));
  Texture holes{"holes", 4, 4, 4, {}};
  for (int i = 0; i < 16; ++i)
    holes.texels.insert(holes.texels.end(), {.9f, .05f * static_cast<float>(i), .5f, i % 3 == 0 ? .2f : .9f});
  pictures.textures.push_back(holes);
  pictures.materials[1].base_color_texture.texture = 0;
  pictures.materials[2].base_color_texture.texture = 0;
  pictures.materials[2].alpha_mode = AlphaMode::kBlend;
  pictures.cameras[0].aperture_radius_m = .05;
  pictures.cameras[0].focus_distance_m = 4;
  kinds.push_back({"pictures, holes and a lens", std::move(pictures)});
  Scene motion = box(matt({.5f, .5f, .5f}), matt({1, 1, 1}));
  std::vector<Float3> later = motion.meshes[6].positions;
  for (Float3& p : later) p.x += .3f;
  motion.meshes[6].motion_positions = {later};
  motion.cameras[0].shutter_close_s = .1;
  kinds.push_back({"motion", std::move(motion)});
  return kinds;
}

TEST(RayTracer, SpecialisedKernelsDrawTheSameBitsAsTheFullOne) {
  const auto list = requests(24, 24, 4);
  for (const auto& [name, scene] : all_kinds()) {
    SCOPED_TRACE(name);
    const auto special = source_of(scene, 24, 24);
    SourceOptions options;
    options.effects = EffectSet::all();
    options.specialise = false;
    const auto full = source_of(scene, 24, 24, options);
    EXPECT_NE(special->kernel_effects(), EffectSet::all());
    EXPECT_EQ(full->kernel_effects(), EffectSet::all());
    EXPECT_TRUE(same_bits(evaluate(*special, list), evaluate(*full, list)));
    for (int kind = 0; kind < kRayKindCount; ++kind)
      EXPECT_EQ(special->rays(static_cast<RayKind>(kind)), full->rays(static_cast<RayKind>(kind)));
  }
}

TEST(RayTracer, SameBitsForAnyNumberOfThreadsAndPieces) {
  for (const auto& [name, scene] : all_kinds()) {
    SCOPED_TRACE(name);
    const auto source = source_of(scene, 24, 24);
    const auto list = requests(24, 24, 4);
    const auto once = evaluate(*source, list, 1, list.size());
    EXPECT_TRUE(same_bits(once, evaluate(*source, list, 2, 500)));
    EXPECT_TRUE(same_bits(once, evaluate(*source, list, 7, 37)));
    EXPECT_TRUE(same_bits(once, evaluate(*source, list, 1, 1)));
  }
}

TEST(RayTracer, CastsNoRayForAnAbsentEffect) {
  const std::map<RayKind, std::vector<Effect>> needs{
      {RayKind::kShadow, {Effect::kPointLight, Effect::kAreaLight, Effect::kEnvironment}},
      {RayKind::kDiffuse, {Effect::kIndirectDiffuse}},
      {RayKind::kGlossy, {Effect::kGlossy}},
      {RayKind::kMirror, {Effect::kMirror}},
      {RayKind::kRefraction, {Effect::kRefraction}}};
  const auto list = requests(24, 24, 4);
  for (const auto& [name, scene] : all_kinds()) {
    SCOPED_TRACE(name);
    const auto source = source_of(scene, 24, 24);
    evaluate(*source, list);
    EXPECT_EQ(source->rays(RayKind::kCamera), list.size());
    for (const auto& [kind, effects] : needs) {
      bool present = false;
      for (const Effect effect : effects) present |= source->effects().has(effect);
      EXPECT_EQ(source->rays(kind) > 0, present) << ray_kind_name(kind) << ", " << source->analysis().text();
    }
    SourceOptions nothing;
    nothing.effects = EffectSet{};
    const auto bare = source_of(scene, 24, 24, nothing);
    evaluate(*bare, list);
    for (const WorkCount& work : bare->work()) EXPECT_EQ(work.count, work.kind == "camera rays" ? list.size() : 0);
  }
}

TEST(RayTracer, SaysWhichEffectsAndWhy) {
  Scene scene = box(metal({1, 1, 1}, 0), glass(1.5f));
  scene.meshes[5].name = "lamp";
  scene.materials[4].name = "chrome";
  scene.materials[5].name = "window";
  EXPECT_EQ(
      analyse_effects(scene, 0).text(),
      "effects: area-light (mesh 'lamp'), indirect-diffuse (material 0), mirror (material 'chrome'), refraction "
      "(material 'window')");
  EXPECT_EQ(parse_effects("mirror,area-light"), parse_effects("area-light,mirror"));
  EXPECT_EQ(effects_text(parse_effects("mirror,area-light")), "area-light,mirror");
  EXPECT_EQ(parse_effects("none"), EffectSet{});
  EXPECT_EQ(effects_text(EffectSet::all()), "all");
  EXPECT_ANY_THROW(parse_effects("mirrors"));
  EXPECT_ANY_THROW(parse_effects(""));
  EXPECT_ANY_THROW(parse_effects("mirror,"));
}

TEST(RayTracer, LeavesFloatingPointModesAlone) {
  const auto source = source_of(box(matt({1, 1, 1}), matt({1, 1, 1})), 4, 4);
  const auto list = requests(4, 4, 1);
  std::vector<Sample> samples(list.size());
  source->eval(list, samples);
  volatile float small = 1e-38f;
  EXPECT_GT(small * .01f, 0.f);
}

TEST(RayTracer, WideFilmShowsTheSameView) {
  const Scene scene = box(matt({1, 1, 1}), matt({1, 1, 1}));
  SourceOptions wide_options;
  wide_options.picture_aspect = 1;
  const auto square = source_of(scene, 16, 16);
  const auto wide = source_of(scene, 48, 16, wide_options);
  const std::vector<SampleRequest> at{{5.25, 7.5, 1, 5, 7, 0, 0}}, same{{15.75, 7.5, 1, 15, 7, 0, 0}};
  EXPECT_EQ(evaluate(*square, at)[0].position, evaluate(*wide, same)[0].position);
}

TEST(RayTracer, PacketsOfCameraRaysAreThoseOfOneByOne) {
  for (const bool orthographic : {false, true}) {
    Camera seen_from;
    seen_from.orthographic = orthographic;
    seen_from.poses[0] = {{.3, -.2, 4}, {.8, 0, .6}, {0, 1, 0}, {.6, 0, -.8}};
    SourceOptions film;
    film.width = 30;
    film.height = 17;
    const FilmCamera camera(seen_from, film, {});
    ASSERT_TRUE(camera.is_plain());
    LaneRays lanes;
    camera.prepare(lanes);
    for (const int n : {16, 1, 7, 15, 16, 8}) {
      std::vector<SampleRequest> list;
      for (int i = 0; i < n; ++i) list.push_back({1.7 * i + .1 * n - 2, 17 - 1.3 * i, 1, 0, 0, 0, 0});
      camera.rays(list, lanes);
      for (int i = 0; i < n; ++i) {
        SCOPED_TRACE(std::to_string(n) + ", " + std::to_string(i));
        const Ray ray = lanes.ray(i), alone = camera.ray(list[i].x, list[i].y, 0, 0, 0);
        // Both are rounded to floats once, directions again when made unit length.
        constexpr float kDirection = 1.5e-7f, kOrigin = 5e-7f;
        EXPECT_LE(length(ray.direction - alone.direction), kDirection);
        EXPECT_LE(length(ray.origin - alone.origin), kOrigin);
      }
    }
  }
}

// Where only colour is asked for, most samples take a short way past all that finds out more.
TEST(RayTracer, ColourAloneIsTheSameAndLeavesTheRestAsItWas) {
  Scene scene = box(matt({.5f, .25f, .75f}), matt({.2f, .3f, .9f}));
  for (Material& material : scene.materials) material.unlit = true;
  scene.meshes.erase(scene.meshes.begin() + 2);  // some rays meet nothing
  SourceOptions colour_only;
  colour_only.geometry = false;
  const auto source = source_of(scene, 24, 24), fast = source_of(scene, 24, 24, colour_only);
  for (const size_t at_once : {1u, 3u, 16u, 37u, 2304u}) {
    auto list = requests(24, 24, 4);
    for (SampleRequest& request : list) request.x += .11 * request.index;
    Sample before;
    before.rgb = {-1, -1, -1};
    before.valid = false;
    before.distance = -7;
    before.position = before.normal = before.albedo = {-3, -4, -5};
    before.object_id = before.material_id = 77;
    std::vector<Sample> samples(list.size(), before);
    for (size_t first = 0; first < list.size(); first += at_once) {
      const size_t n = std::min(at_once, list.size() - first);
      fast->eval(std::span(list).subspan(first, n), std::span(samples).subspan(first, n));
    }
    const auto expected = evaluate(*source, list);
    for (size_t i = 0; i < list.size(); ++i) {
      ASSERT_EQ(samples[i].rgb, expected[i].rgb) << i << ", " << at_once << " at once";
      ASSERT_TRUE(samples[i].valid);
      ASSERT_EQ(samples[i].distance, before.distance);
      ASSERT_EQ(samples[i].position, before.position);
      ASSERT_EQ(samples[i].normal, before.normal);
      ASSERT_EQ(samples[i].albedo, before.albedo);
      ASSERT_EQ(samples[i].object_id, before.object_id);
      ASSERT_EQ(samples[i].material_id, before.material_id);
    }
  }
}

TEST(RayTracer, RefusesWhatIsOutOfRange) {
  const Scene scene = box(matt({1, 1, 1}), matt({1, 1, 1}));
  SourceOptions options;
  EXPECT_ANY_THROW(source_of(scene, 0, 16));
  options.max_depth = -1;
  EXPECT_ANY_THROW(source_of(scene, 16, 16, options));
  options.max_depth = 8;
  options.camera = 1;
  EXPECT_ANY_THROW(source_of(scene, 16, 16, options));
}

}  // namespace
}  // namespace triad::raytracer::testing
