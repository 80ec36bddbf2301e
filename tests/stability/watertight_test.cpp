// SPDX-License-Identifier: Apache-2.0
// Rays aimed at edges and corners of closed meshes must not pass. TRIAD_WATERTIGHT_RAYS=1e8 in the environment shoots
// that many at the globe instead of some 10^6.
#include <embree3/rtcore.h>

#include <cstdlib>

#include "closed_meshes.hpp"
#include "stability_table.hpp"

namespace triad::raytracer::testing {
namespace {

uint64_t rays_to_shoot() {
  const char* wanted = std::getenv("TRIAD_WATERTIGHT_RAYS");
  return wanted ? static_cast<uint64_t>(std::atof(wanted)) : 1'200'000;
}

// On two threads, alternately in packets, singly and as shadow rays.
Leaks shoot(const Closed& closed, Float3 centre, Float3 reach_m, bool outside, float slack_m, uint64_t shots) {
  std::vector<Leaks> parts(6);
  std::vector<std::jthread> pool;
  for (uint64_t thread = 0; thread < 2; ++thread)
    pool.emplace_back([&, thread] {
      for (uint64_t way = 0; way < 3; ++way)
        parts[3 * thread + way] = leaks(*closed.geometry, closed.scene.meshes[0], centre, reach_m, outside, slack_m,
                                        shots / 6, static_cast<Way>(way), 3 * thread + way);
    });
  pool.clear();
  Leaks sum;
  for (const Leaks& part : parts) {
    sum.at_edges += part.at_edges;
    sum.at_corners += part.at_corners;
    sum.rays += part.rays;
  }
  return sum;
}

void expect_closed(const std::string& what, const Leaks& found) {
  stability::never("geometry", what + ": leaks", found.at_edges + found.at_corners, found.rays);
}

const Closed& earth() {
  static const Closed globe_of_100000(globe(158, 320, 1, {}));
  return globe_of_100000;
}

}  // namespace

TEST(GeometryStability, ClosedMeshLeaksNoRayFromInside) {
  EXPECT_GE(earth().scene.triangle_count(), 100'000u);
  expect_closed("10^5 triangles, rays from inside", shoot(earth(), {}, {.5f, .5f, .5f}, false, 0, rays_to_shoot()));
}

TEST(GeometryStability, ClosedMeshLeaksNoRayFromOutside) {
  for (const float distance : {1.5f, 4.f, 30.f})
    expect_closed(fmt::format("10^5 triangles, rays from {} radii", distance),
                  shoot(earth(), {}, {distance, distance, distance}, true, .05f, rays_to_shoot() / 3));
}

// Why corners have caps: the same mesh in Embree alone, its robust mode on.
TEST(GeometryStability, RobustEmbreeAloneHasPinholesAtCorners) {
  const Mesh& mesh = earth().scene.meshes[0];
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene tree = rtcNewScene(device);
  rtcSetSceneFlags(tree, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  std::copy(mesh.positions.begin(), mesh.positions.end(),
            static_cast<Float3*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                         sizeof(Float3), mesh.positions.size())));
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                             sizeof(mesh.indices[0]), mesh.indices.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(tree, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(tree);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> around(-.5f, .5f);
  uint64_t count = 0;
  constexpr int kRays = 100'000;
  for (int i = 0; i < kRays; ++i) {
    const Float3 from{around(random), around(random), around(random)};
    const Float3 towards = normalise(mesh.positions[random() % mesh.positions.size()] - from);
    RTCRayHit ray{};
    ray.ray = {from.x, from.y, from.z, 0, towards.x, towards.y, towards.z, 0, INFINITY, ~0u, 0, 0};
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(tree, &context, &ray);
    count += ray.hit.geomID == RTC_INVALID_GEOMETRY_ID;
  }
  rtcReleaseScene(tree);
  rtcReleaseDevice(device);
  stability::naive_fails("geometry", "10^5 triangles, leaks of 10^5 rays at corners, no caps",
                         static_cast<double>(count), 50);
}

TEST(GeometryStability, NeedleFansLeakNothing) {
  for (const bool pointed : {false, true}) {
    const Closed closed(drum(1000, 1, 1, {}, pointed));
    // Inside of a cone, too, if near its axis and its base.
    expect_closed(pointed ? "cone of 1000 sides" : "cylinder of 1000 sides",
                  shoot(closed, {0, -.2f, 0}, {.25f, .2f, .25f}, false, 0, 150'000));
  }
}

TEST(GeometryStability, TinyHugeAndFarMeshesLeakNothing) {
  for (const float radius_m : {1e-6f, 1e6f}) {
    const Closed closed(ball(5, radius_m));
    expect_closed(fmt::format("ball of {:g} m", radius_m),
                  shoot(closed, {}, {radius_m / 2, radius_m / 2, radius_m / 2}, false, 0, 300'000));
  }
  const Float3 far{100, -70, 30};
  const Closed closed(ball(5, 1, far));
  expect_closed("ball of 1 m, 100 m from the origin", shoot(closed, far, {.5f, .5f, .5f}, false, 0, 300'000));
  // Corners that do not share vertices, as exporters write them for flat shading.
  Mesh apart;
  const Mesh whole = ball(5);
  for (const auto& triangle : whole.indices) {
    const auto first = static_cast<uint32_t>(apart.positions.size());
    for (const uint32_t corner : triangle) apart.positions.push_back(whole.positions[corner]);
    apart.indices.push_back({first, first + 1, first + 2});
  }
  const Closed unshared(std::move(apart));
  expect_closed("ball whose triangles share no vertices", shoot(unshared, {}, {.5f, .5f, .5f}, false, 0, 300'000));
}

TEST(GeometryStability, MovingMeshLeaksNothing) {
  Scene scene;
  Mesh mesh = ball(5);
  mesh.motion_positions.push_back(mesh.positions);
  for (Float3& p : mesh.motion_positions[0]) p.x += 10;
  add_mesh(scene, mesh, add_material(scene, matt({1, 1, 1})));
  EffectSet effects;
  effects.add(Effect::kMotionBlur);
  const Geometry geometry(scene, effects, {});
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  const uint64_t keys[kLanes] = {};
  uint64_t count = 0;
  constexpr int kRays = 200'000;
  for (int i = 0; i < kRays; ++i) {
    // Halfway, to the last bit: rays at other times aim beside the corner by a rounding of the aim.
    const float time = i % 2 == 0 ? .5f : unit(random);
    const uint32_t vertex = static_cast<uint32_t>(random() % mesh.positions.size());
    const Float3 aim = lerp(mesh.positions[vertex], mesh.motion_positions[0][vertex], time);
    Ray ray{{10 * time + unit(random) - .5f, unit(random) - .5f, unit(random) - .5f}, {}};
    ray.direction = normalise(aim - ray.origin);
    ray.time = time;
    HitId hit;
    geometry.intersect(&ray, 1, keys, false, &hit);
    count += hit.mesh == kMiss;
  }
  stability::never("geometry", "moving ball, rays at its corners: leaks", count, kRays);
}

// A convex mesh never stands in its own light: no ray that leaves it meets it again.
TEST(GeometryStability, ConvexMeshDoesNotShadowItself) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> around(-1, 1);
  const Closed ball_closed(ball(5)), drum_closed(drum(64, 1, 1, {}, false));
  uint64_t blocked = 0, rays = 0;
  for (const Closed* closed : {&ball_closed, &drum_closed})
    for (int i = 0; i < 150'000; ++i) {
      const auto direction = [&] { return normalise_safely({around(random), around(random), around(random)}); };
      Ray ray{direction() * 3, {}};
      const Float3 aim{around(random), around(random), around(random)};
      ray.direction = normalise_safely(aim * .5f - ray.origin);
      const uint64_t keys[kLanes] = {};
      HitId hit;
      closed->geometry->intersect(&ray, 1, keys, false, &hit);
      if (hit.mesh == kMiss) continue;
      const Surface surface = closed->geometry->surface(ray, hit, false);
      Ray next{surface.position + surface.geometric_normal * surface.offset_m, direction()};
      if (dot(next.direction, surface.geometric_normal) < 0) next.direction = -next.direction;
      blocked += closed->geometry->occluded(&next, 1, keys, false) & 1;
      ++rays;
    }
  stability::never("geometry", "convex meshes: rays that leave and are blocked", blocked, rays);
}

TEST(GeometryStability, NoLightEntersAClosedMesh) {
  Scene scene;
  add_mesh(scene, ball(5), add_material(scene, matt({1, 1, 1})));
  scene.environment.radiance = {1e6f, 1e6f, 1e6f};
  Camera camera;
  camera.yfov_rad = 2.5;
  scene.cameras = {camera};
  const auto source = source_of(scene, 64, 64);
  uint64_t lit = 0;
  const auto samples = evaluate(*source, requests(64, 64, 16));
  for (const Sample& sample : samples) lit += sample.rgb != std::array<float, 3>{};
  stability::never("geometry", "inside a closed ball under a bright sky: samples lit", lit, samples.size());
}

}  // namespace triad::raytracer::testing
