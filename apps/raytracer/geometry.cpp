// SPDX-License-Identifier: Apache-2.0
#include "geometry.hpp"

#include <cstring>
#include <numeric>
#include <triad/base/error.hpp>
#include <triad/base/random.hpp>
#include <triad/numeric/widest.hpp>

#include "texture.hpp"

namespace triad::raytracer {
namespace {

Float3 motion_lerp(const std::vector<Float3>& first, const std::vector<std::vector<Float3>>& later, uint32_t vertex,
                   float time) {
  const float at = std::clamp(time, 0.f, 1.f) * static_cast<float>(later.size());
  const size_t step = std::min(static_cast<size_t>(at), later.size() - 1);
  const Float3 a = step == 0 ? first[vertex] : later[step - 1][vertex];
  return lerp(a, later[step][vertex], at - static_cast<float>(step));
}

template <int K>
struct Packet;
template <>
struct Packet<8> {
  using Hit = RTCRayHit8;
  using Shadow = RTCRay8;
  static constexpr auto intersect = rtcIntersect8;
  static constexpr auto occluded = rtcOccluded8;
};
template <>
struct Packet<16> {
  using Hit = RTCRayHit16;
  using Shadow = RTCRay16;
  static constexpr auto intersect = rtcIntersect16;
  static constexpr auto occluded = rtcOccluded16;
};

template <class R>
void put(R& packet, int i, const Ray& ray, int id) {
  packet.org_x[i] = ray.origin.x;
  packet.org_y[i] = ray.origin.y;
  packet.org_z[i] = ray.origin.z;
  packet.dir_x[i] = ray.direction.x;
  packet.dir_y[i] = ray.direction.y;
  packet.dir_z[i] = ray.direction.z;
  packet.tnear[i] = 0;
  packet.tfar[i] = ray.end;
  packet.time[i] = ray.time;
  packet.mask[i] = ~0u;
  packet.id[i] = static_cast<unsigned>(id);
  packet.flags[i] = 0;
}

RTCRay single(const Ray& ray, int id) {
  return {ray.origin.x,    ray.origin.y, ray.origin.z, 0,   ray.direction.x,           ray.direction.y,
          ray.direction.z, ray.time,     ray.end,      ~0u, static_cast<unsigned>(id), 0};
}

template <int K>
void intersect_packets(RTCScene tree, TraceContext& context, const Ray* rays, uint32_t active, HitId* hits) {
  for (int first = 0; first < kLanes; first += K) {
    alignas(64) int valid[K];
    typename Packet<K>::Hit packet;
    bool any = false;
    for (int i = 0; i < K; ++i) {
      const bool on = (active >> (first + i) & 1) != 0;
      valid[i] = on ? -1 : 0;
      any |= on;
      packet.hit.geomID[i] = kMiss;
      if (on) put(packet.ray, i, rays[first + i], first + i);
    }
    if (!any) continue;
    Packet<K>::intersect(valid, tree, &context, &packet);
    for (int i = 0; i < K; ++i)
      if (valid[i]) hits[first + i] = {packet.hit.geomID[i], packet.hit.primID[i]};
  }
}

// Lanes first ... first + 7 of a packet of 16, as one of 8.
void intersect_half(const int* valid, RTCScene tree, TraceContext& context, RTCRayHit16& packet, int first) {
  RTCRayHit8 half;
  const auto split = [first](auto& to, const auto& from) { std::memcpy(to, from + first, sizeof(to)); };
  const auto join = [first](auto& to, const auto& from) { std::memcpy(to + first, from, sizeof(from)); };
  split(half.ray.org_x, packet.ray.org_x);
  split(half.ray.org_y, packet.ray.org_y);
  split(half.ray.org_z, packet.ray.org_z);
  split(half.ray.tnear, packet.ray.tnear);
  split(half.ray.dir_x, packet.ray.dir_x);
  split(half.ray.dir_y, packet.ray.dir_y);
  split(half.ray.dir_z, packet.ray.dir_z);
  split(half.ray.time, packet.ray.time);
  split(half.ray.tfar, packet.ray.tfar);
  split(half.ray.mask, packet.ray.mask);
  split(half.ray.id, packet.ray.id);
  split(half.ray.flags, packet.ray.flags);
  split(half.hit.geomID, packet.hit.geomID);
  alignas(32) int lanes[8];
  std::copy(valid, valid + 8, lanes);
  rtcIntersect8(lanes, tree, &context, &half);
  join(packet.hit.geomID, half.hit.geomID);
  join(packet.hit.primID, half.hit.primID);
  for (int i = 0; i < 8; ++i) {  // a lane that met nothing has none
    if (half.hit.geomID[i] == kMiss) continue;
    packet.hit.u[first + i] = half.hit.u[i];
    packet.hit.v[first + i] = half.hit.v[i];
  }
}

template <int K>
uint32_t occluded_packets(RTCScene tree, TraceContext& context, const Ray* rays, uint32_t active) {
  uint32_t blocked = 0;
  for (int first = 0; first < kLanes; first += K) {
    alignas(64) int valid[K];
    typename Packet<K>::Shadow packet;
    bool any = false;
    for (int i = 0; i < K; ++i) {
      const bool on = (active >> (first + i) & 1) != 0;
      valid[i] = on ? -1 : 0;
      any |= on;
      if (on) put(packet, i, rays[first + i], first + i);
    }
    if (!any) continue;
    Packet<K>::occluded(valid, tree, &context, &packet);
    for (int i = 0; i < K; ++i)
      if (valid[i] && packet.tfar[i] < 0) blocked |= 1u << (first + i);
  }
  return blocked;
}

TraceContext make_context(const uint64_t* lane_keys, bool coherent) {
  TraceContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  context.lane_keys = lane_keys;
  return context;
}

}  // namespace

// Runs for each candidate hit, in whatever order Embree visits them, so its random number hashes the triangle.
void Geometry::alpha_filter(const RTCFilterFunctionNArguments* args) {
  const AlphaUser& user = *static_cast<const AlphaUser*>(args->geometryUserPtr);
  const Mesh& mesh = *user.mesh;
  const Material& material = user.scene->materials[mesh.material];
  const uint64_t* keys = static_cast<const TraceContext*>(args->context)->lane_keys;
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const unsigned triangle = RTCHitN_primID(args->hit, args->N, i);
    float alpha = material.alpha;
    const TextureUse& use = material.base_color_texture;
    if (user.textures && use.texture >= 0) {
      const float u = RTCHitN_u(args->hit, args->N, i), v = RTCHitN_v(args->hit, args->N, i), w = 1 - u - v;
      std::array<Float2, 2> uv{};
      const auto& corner = mesh.indices[triangle];
      const auto& set = mesh.texcoords[use.texcoord];
      if (!set.empty()) {
        const Float2 a = set[corner[0]], b = set[corner[1]], c = set[corner[2]];
        uv[use.texcoord] = {w * a.x + u * b.x + v * c.x, w * a.y + u * b.y + v * c.y};
      }
      alpha *= lookup(*user.scene, use, uv)[3];
    }
    if (material.alpha_mode == AlphaMode::kMask) {
      if (!(alpha >= material.alpha_cutoff)) args->valid[i] = 0;
      continue;
    }
    const uint64_t where = uint64_t{RTCHitN_geomID(args->hit, args->N, i)} << 32 | triangle;
    const uint64_t hash = mix_bits(keys[RTCRayN_id(args->ray, args->N, i)] ^ mix_bits(where + kGoldenIncrement));
    if (!(unit_float(static_cast<uint32_t>(hash >> 32)) < alpha)) args->valid[i] = 0;
  }
}

Geometry::Geometry(const Scene& scene, EffectSet effects, const SourceOptions& options)
    : scene_(scene),
      motion_(effects.has(Effect::kMotionBlur)),
      memory_(std::make_unique<std::atomic<int64_t>>(0)),
      device_(rtcNewDevice(nullptr)) {
  if (!device_) throw_internal("Embree: no device (error " + std::to_string(rtcGetDeviceError(nullptr)) + ")");
  rtcSetDeviceMemoryMonitorFunction(
      device_.get(),
      [](void* sum, ssize_t bytes, bool) {
        static_cast<std::atomic<int64_t>*>(sum)->fetch_add(bytes, std::memory_order_relaxed);
        return true;
      },
      memory_.get());
  if (rtcGetDeviceProperty(device_.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0) width_ = 16;
  tree_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(tree_.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(tree_.get(), RTC_BUILD_QUALITY_MEDIUM);
  if (options.build_progress)
    rtcSetSceneProgressMonitorFunction(tree_.get(), options.build_progress, options.build_progress_user);
  for (size_t i = 0; i < scene.meshes.size(); ++i)
    if (!scene.meshes[i].indices.empty()) add(scene.meshes[i], static_cast<uint32_t>(i), effects);
  rtcCommitScene(tree_.get());
  const RTCError error = rtcGetDeviceError(device_.get());
  if (error == RTC_ERROR_CANCELLED) throw Error(ErrorKind::kCancelled, "cancelled while the scene was built");
  if (error == RTC_ERROR_OUT_OF_MEMORY)
    throw_input(scene.file + ": " + std::to_string(scene.triangle_count()) + " triangles do not fit into memory");
  if (error != RTC_ERROR_NONE) throw_internal("Embree: building failed (error " + std::to_string(error) + ")");
}

void Geometry::add(const Mesh& mesh, uint32_t id, EffectSet effects) {
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const bool moves = motion_ && mesh.moves();
  const unsigned steps = moves ? static_cast<unsigned>(mesh.motion_positions.size()) + 1 : 1;
  rtcSetGeometryTimeStepCount(geometry, steps);
  for (unsigned step = 0; step < steps; ++step) {
    const std::vector<Float3>& positions = step == 0 ? mesh.positions : mesh.motion_positions[step - 1];
    // Embree's own buffer: it reads 16 bytes for each vertex, four past the end of a vector.
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3,
                                             sizeof(Float3), positions.size());
    if (vertices) std::memcpy(vertices, positions.data(), positions.size() * sizeof(Float3));
  }
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                             sizeof(mesh.indices[0]), mesh.indices.size());
  if (effects.has(Effect::kAlpha) && scene_.materials[mesh.material].alpha_mode != AlphaMode::kOpaque) {
    alpha_users_.push_back(std::make_unique<AlphaUser>(AlphaUser{&scene_, &mesh, effects.has(Effect::kTexture)}));
    rtcSetGeometryUserData(geometry, alpha_users_.back().get());
    rtcSetGeometryIntersectFilterFunction(geometry, alpha_filter);
    rtcSetGeometryOccludedFilterFunction(geometry, alpha_filter);
  }
  attach(geometry, id);
  // Where a material has holes, a pinhole more is no leak.
  if (scene_.materials[mesh.material].alpha_mode == AlphaMode::kOpaque) add_caps(mesh, id);
}

void Geometry::attach(RTCGeometry geometry, uint32_t id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(tree_.get(), geometry, id);
  rtcReleaseGeometry(geometry);
}

void Geometry::add_caps(const Mesh& mesh, uint32_t id) {
  const bool moves = motion_ && mesh.moves();
  const CornerCaps made(mesh, moves);
  const size_t count = made.caps().size();
  if (count == 0) return;
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const unsigned steps = moves ? static_cast<unsigned>(mesh.motion_positions.size()) + 1 : 1;
  rtcSetGeometryTimeStepCount(geometry, steps);
  for (unsigned step = 0; step < steps; ++step) {
    void* corners =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, sizeof(Float3), 3 * count);
    if (corners)
      made.place(mesh, step == 0 ? mesh.positions : mesh.motion_positions[step - 1], static_cast<Float3*>(corners));
  }
  void* indices =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), count);
  if (indices) std::iota(static_cast<uint32_t*>(indices), static_cast<uint32_t*>(indices) + 3 * count, 0u);
  cap_users_.push_back(std::make_unique<CapUser>(CapUser{&mesh, id, moves, made.caps()}));
  rtcSetGeometryUserData(geometry, cap_users_.back().get());
  rtcSetGeometryIntersectFilterFunction(geometry, cap_filter);
  rtcSetGeometryOccludedFilterFunction(geometry, cap_filter);
  attach(geometry, static_cast<uint32_t>(scene_.meshes.size()) + id);
}

// Runs for the few rays that meet a cap, and lets those of them pass that have no need of it. A hit becomes one of
// the triangle that stands for the corner, on its edge.
void Geometry::cap_filter(const RTCFilterFunctionNArguments* args) {
  const CapUser& user = *static_cast<const CapUser*>(args->geometryUserPtr);
  const unsigned n = args->N;
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] == 0) continue;
    const CornerCap cap = user.caps[RTCHitN_primID(args->hit, n, i)];
    const Mesh& mesh = *user.mesh;
    const Float3 corner =
        user.motion ? motion_lerp(mesh.positions, mesh.motion_positions, cap.vertex, RTCRayN_time(args->ray, n, i))
                    : mesh.positions[cap.vertex];
    const Double3 origin{RTCRayN_org_x(args->ray, n, i), RTCRayN_org_y(args->ray, n, i),
                         RTCRayN_org_z(args->ray, n, i)};
    const Double3 direction{RTCRayN_dir_x(args->ray, n, i), RTCRayN_dir_y(args->ray, n, i),
                            RTCRayN_dir_z(args->ray, n, i)};
    if (!grazes_corner(origin, direction, corner)) {
      args->valid[i] = 0;
      continue;
    }
    RTCHitN_geomID(args->hit, n, i) = user.mesh_id;
    RTCHitN_primID(args->hit, n, i) = cap.triangle;
    RTCHitN_u(args->hit, n, i) = RTCHitN_v(args->hit, n, i) = 0;
  }
}

uint64_t Geometry::memory_bytes() const {
  uint64_t bytes = static_cast<uint64_t>(std::max<int64_t>(0, memory_->load()));
  for (const auto& user : cap_users_) bytes += user->caps.size() * sizeof(CornerCap);
  return bytes;
}

void Geometry::intersect(const Ray* rays, uint32_t active, const uint64_t* lane_keys, bool coherent,
                         HitId* hits) const {
  TraceContext context = make_context(lane_keys, coherent);
  if (coherent && width_ == 16) return intersect_packets<16>(tree_.get(), context, rays, active, hits);
  if (coherent) return intersect_packets<8>(tree_.get(), context, rays, active, hits);
  for (int i = 0; i < kLanes; ++i) {
    if ((active >> i & 1) == 0) continue;
    RTCRayHit one;
    one.ray = single(rays[i], i);
    one.hit.geomID = kMiss;
    rtcIntersect1(tree_.get(), &context, &one);
    hits[i] = {one.hit.geomID, one.hit.primID};
  }
}

uint32_t Geometry::first_hits(LaneRays& rays, int n, const uint64_t* lane_keys) const {
  TraceContext context = make_context(lane_keys, true);
  RTCRayHit16& packet = rays.packet_;
  alignas(64) int valid[kLanes];
  for (int i = 0; i < kLanes; ++i) {
    valid[i] = i < n ? -1 : 0;
    packet.ray.tfar[i] = std::numeric_limits<float>::infinity();
    packet.hit.geomID[i] = kMiss;
    packet.hit.u[i] = packet.hit.v[i] = 1.f / 3;
  }
  if (width_ == 16)
    rtcIntersect16(valid, tree_.get(), &context, &packet);
  else
    for (int first = 0; first < n; first += 8) intersect_half(valid + first, tree_.get(), context, packet, first);
  constexpr float kNear = 1e-4f;
  uint32_t near_edge = 0;
  run_widest([&]() TRIAD_INLINE_BODY {
    uint32_t bits = 0;
    for (int i = 0; i < kLanes; ++i) {
      const float u = packet.hit.u[i], v = packet.hit.v[i];
      bits |= static_cast<uint32_t>((u < kNear) | (v < kNear) | (1 - u - v < kNear)) << i;
    }
    near_edge = bits;
  });
  return near_edge;
}

uint32_t Geometry::occluded(const Ray* rays, uint32_t active, const uint64_t* lane_keys, bool coherent) const {
  TraceContext context = make_context(lane_keys, coherent);
  if (coherent && width_ == 16) return occluded_packets<16>(tree_.get(), context, rays, active);
  if (coherent) return occluded_packets<8>(tree_.get(), context, rays, active);
  uint32_t blocked = 0;
  for (int i = 0; i < kLanes; ++i) {
    if ((active >> i & 1) == 0) continue;
    RTCRay one = single(rays[i], i);
    rtcOccluded1(tree_.get(), &context, &one);
    if (one.tfar < 0) blocked |= 1u << i;
  }
  return blocked;
}

std::array<Float3, 3> Geometry::corners(HitId triangle, float time) const {
  const Mesh& mesh = scene_.meshes[triangle.mesh];
  const auto& corner = mesh.indices[triangle.triangle];
  if (!motion_ || !mesh.moves())
    return {mesh.positions[corner[0]], mesh.positions[corner[1]], mesh.positions[corner[2]]};
  std::array<Float3, 3> at;
  for (int i = 0; i < 3; ++i) at[i] = motion_lerp(mesh.positions, mesh.motion_positions, corner[i], time);
  return at;
}

Surface Geometry::surface(const Ray& ray, HitId hit, bool texcoords) const {
  const Mesh& mesh = scene_.meshes[hit.mesh];
  const auto& corner = mesh.indices[hit.triangle];
  const std::array<Float3, 3> at = corners(hit, ray.time);
  // Moeller and Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997, in double precision.
  struct D {
    double x, y, z;
  };
  const auto minus = [](Float3 a, Float3 b) {
    return D{static_cast<double>(a.x) - b.x, static_cast<double>(a.y) - b.y, static_cast<double>(a.z) - b.z};
  };
  const auto times = [](D a, D b) { return D{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; };
  const auto inner = [](D a, D b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  const D edge1 = minus(at[1], at[0]), edge2 = minus(at[2], at[0]), to_origin = minus(ray.origin, at[0]);
  const D direction{ray.direction.x, ray.direction.y, ray.direction.z};
  const D across = times(direction, edge2), along = times(to_origin, edge1), normal = times(edge1, edge2);
  const double determinant = inner(edge1, across);
  double u = 1. / 3, v = 1. / 3;
  Surface surface;
  if (determinant != 0) {
    const double inverse = 1 / determinant;
    u = std::clamp(inner(to_origin, across) * inverse, 0., 1.);
    v = std::clamp(inner(direction, along) * inverse, 0., 1. - u);
    surface.distance = static_cast<float>(std::max(0., inner(edge2, along) * inverse));
  }
  const double w = 1 - u - v;
  surface.to_edge = static_cast<float>(std::min(u, std::min(v, w)));
  surface.position = {static_cast<float>(at[0].x + u * edge1.x + v * edge2.x),
                      static_cast<float>(at[0].y + u * edge1.y + v * edge2.y),
                      static_cast<float>(at[0].z + u * edge1.z + v * edge2.z)};
  const double square = inner(normal, normal);
  if (square > 0) {
    const double size = std::sqrt(square), inverse = 1 / size;
    surface.area_m2 = static_cast<float>(size / 2);
    surface.geometric_normal = {static_cast<float>(normal.x * inverse), static_cast<float>(normal.y * inverse),
                                static_cast<float>(normal.z * inverse)};
  } else {
    surface.geometric_normal = -normalise_safely(ray.direction);
  }
  // Embree tests the next ray in float, with corners relative to its origin: its errors are a few ulps of the
  // farthest corner's distance; storing the position costs half an ulp of its largest coordinate.
  constexpr float kUlps = 8 * std::numeric_limits<float>::epsilon();
  const auto largest = [](Float3 a) { return std::max(std::abs(a.x), std::max(std::abs(a.y), std::abs(a.z))); };
  surface.offset_m = kUlps * (largest(surface.position) + std::max(largest(at[0] - surface.position),
                                                                   std::max(largest(at[1] - surface.position),
                                                                            largest(at[2] - surface.position))));

  const float fu = static_cast<float>(u), fv = static_cast<float>(v), fw = static_cast<float>(w);
  surface.shading_normal = surface.geometric_normal;
  if (!mesh.normals.empty()) {
    Float3 sum{};
    const float weights[3] = {fw, fu, fv};
    for (int i = 0; i < 3; ++i) {
      const bool moves = motion_ && !mesh.motion_normals.empty();
      sum += weights[i] *
             (moves ? motion_lerp(mesh.normals, mesh.motion_normals, corner[i], ray.time) : mesh.normals[corner[i]]);
    }
    const Float3 smooth = normalise_safely(sum);
    if (dot(smooth, surface.geometric_normal) > 0) surface.shading_normal = smooth;
  }
  if (texcoords) {
    for (int set = 0; set < 2; ++set) {
      const auto& uv = mesh.texcoords[set];
      if (uv.empty()) continue;
      const Float2 a = uv[corner[0]], b = uv[corner[1]], c = uv[corner[2]];
      surface.uv[set] = {fw * a.x + fu * b.x + fv * c.x, fw * a.y + fu * b.y + fv * c.y};
    }
  }
  return surface;
}

}  // namespace triad::raytracer
