// SPDX-License-Identifier: Apache-2.0
// The scene's triangles in Embree, and what a hit on them looks like.
#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <memory>
#include <vector>

#include "corner_caps.hpp"
#include "effects.hpp"
#include "scene_source.hpp"
#include "vec.hpp"

namespace triad::raytracer {

// Paths traced side by side: as many as the widest packet.
inline constexpr int kLanes = 16;

// What Embree hands to the filter that decides whether a surface with alpha is there: the lane's number is the
// ray's id.
struct TraceContext : RTCIntersectContext {
  const uint64_t* lane_keys = nullptr;  // one for each lane: what random numbers of this path's segment hash from
};

// One ray; directions need not be unit length, but the ends count in lengths of it.
struct Ray {
  Float3 origin, direction;
  float end = std::numeric_limits<float>::infinity();
  float time = 0;  // 0 ... 1 over the shutter's time
};

constexpr uint32_t kMiss = RTC_INVALID_GEOMETRY_ID;
struct HitId {
  uint32_t mesh = kMiss, triangle = 0;
};

// kLanes rays without end and what they meet first, lane by lane, as Embree reads and writes them.
class LaneRays {
 public:
  LaneRays() : packet_{} {
    for (int i = 0; i < kLanes; ++i) {
      packet_.ray.mask[i] = ~0u;
      packet_.ray.id[i] = static_cast<unsigned>(i);
    }
  }
  // Directions need not be unit length.
  void set(int i, Float3 origin, Float3 direction) {
    packet_.ray.org_x[i] = origin.x;
    packet_.ray.org_y[i] = origin.y;
    packet_.ray.org_z[i] = origin.z;
    packet_.ray.dir_x[i] = direction.x;
    packet_.ray.dir_y[i] = direction.y;
    packet_.ray.dir_z[i] = direction.z;
  }
  void set_time(int i, float time) { packet_.ray.time[i] = time; }
  // kLanes numbers each: x, y and z.
  std::array<float*, 3> origins() { return {packet_.ray.org_x, packet_.ray.org_y, packet_.ray.org_z}; }
  std::array<float*, 3> directions() { return {packet_.ray.dir_x, packet_.ray.dir_y, packet_.ray.dir_z}; }

  // With a direction of unit length.
  Ray ray(int i) const {
    const auto& r = packet_.ray;
    return {{r.org_x[i], r.org_y[i], r.org_z[i]},
            normalise_safely({r.dir_x[i], r.dir_y[i], r.dir_z[i]}),
            Ray{}.end,
            r.time[i]};
  }
  HitId hit(int i) const { return {packet_.hit.geomID[i], packet_.hit.primID[i]}; }

 private:
  friend class Geometry;
  alignas(64) RTCRayHit16 packet_;
};

// A point on a surface, recomputed in double precision from the triangle that Embree found: it does not depend on
// the width of the packet that found it, and is within an ulp of the plane.
struct Surface {
  Float3 position;
  Float3 geometric_normal;  // unit length, out of the triangle's front
  Float3 shading_normal;    // unit length, on the same side of the triangle
  float distance = 0;       // in lengths of the ray's direction
  float offset_m = 0;       // how far a ray must start from here so that it cannot meet the triangle again
  float area_m2 = 0;        // of the triangle at that time
  float to_edge = 1;        // the least barycentric coordinate, 0 on an edge
  std::array<Float2, 2> uv{};
};

class Geometry {
 public:
  // Reads alpha and motion only if the set says so. The scene must outlive it.
  Geometry(const Scene& scene, EffectSet effects, const SourceOptions& options);

  // active: bit i says that ray i of `rays` counts. With coherent, rays go in packets.
  void intersect(const Ray* rays, uint32_t active, const uint64_t* lane_keys, bool coherent, HitId* hits) const;
  // In packets, for lanes 0 ... n - 1. Returns the bits of those that met their triangle within 1e-4 of an edge, in
  // barycentric coordinates.
  uint32_t first_hits(LaneRays& rays, int n, const uint64_t* lane_keys) const;
  // Bits of the rays that are blocked.
  uint32_t occluded(const Ray* rays, uint32_t active, const uint64_t* lane_keys, bool coherent) const;

  // texcoords: false where nothing reads them.
  Surface surface(const Ray& ray, HitId hit, bool texcoords) const;
  // Whether the mesh's corners depend on the time.
  bool moves(uint32_t mesh) const { return motion_ && scene_.meshes[mesh].moves(); }
  // The triangle's corners at a time.
  std::array<Float3, 3> corners(HitId triangle, float time) const;

  // Embree's memory and ours; the scene's own is the scene's.
  uint64_t memory_bytes() const;
  int packet_width() const { return width_; }

 private:
  struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };
  struct ReleaseScene {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  void add(const Mesh& mesh, uint32_t id, EffectSet effects);
  void add_caps(const Mesh& mesh, uint32_t id);
  void attach(RTCGeometry geometry, uint32_t id);

  const Scene& scene_;
  bool motion_;
  std::unique_ptr<std::atomic<int64_t>> memory_;
  std::unique_ptr<RTCDeviceTy, ReleaseDevice> device_;
  std::unique_ptr<RTCSceneTy, ReleaseScene> tree_;
  struct AlphaUser {
    const Scene* scene;
    const Mesh* mesh;
    bool textures;
  };
  std::vector<std::unique_ptr<AlphaUser>> alpha_users_;
  static void alpha_filter(const RTCFilterFunctionNArguments* args);
  struct CapUser {
    const Mesh* mesh;
    uint32_t mesh_id;
    bool motion;
    std::vector<CornerCap> caps;
  };
  std::vector<std::unique_ptr<CapUser>> cap_users_;
  static void cap_filter(const RTCFilterFunctionNArguments* args);
  int width_ = 8;
};

}  // namespace triad::raytracer
