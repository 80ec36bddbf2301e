// SPDX-License-Identifier: Apache-2.0
// From a place on the film to a ray.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/source.hpp>

#include "geometry.hpp"

namespace triad::raytracer {

// A camera prepared for a film. Thread-safe.
class FilmCamera {
 public:
  FilmCamera(const Camera& camera, const SourceOptions& options, EffectSet effects)
      : camera_(camera), width_(options.width), height_(options.height) {
    half_height_ = camera.orthographic ? camera.half_height_m : std::tan(camera.yfov_rad / 2);
    const double aspect = options.picture_aspect > 0 ? options.picture_aspect : width_ / height_;
    half_width_ = half_height_ * aspect;
    lens_ = effects.has(Effect::kDepthOfField) && camera.aperture_radius_m > 0;
    moves_ = effects.has(Effect::kMotionBlur) && camera.poses.size() > 1;
  }

  bool has_lens() const { return lens_; }
  // Whether every ray starts and ends at one time and depends on its place on the film alone, so that rays() serves.
  bool is_plain() const { return !lens_ && !moves_; }

  // What rays() gives every lane; its directions are of unit length for an orthographic camera only.
  void prepare(LaneRays& out) const {
    for (int i = 0; i < kLanes; ++i)
      out.set(i, in_world(camera_.poses.front(), {}, camera_.poses.front().position_m, 1),
              in_world(camera_.poses.front(), {0, 0, 1}, {}, 1));
  }
  // The rays of up to kLanes places on the film, for a camera that is_plain(): origins and directions in which
  // ray() differs are overwritten, the rest is as prepare() left it.
  void rays(std::span<const SampleRequest> requests, LaneRays& out) const {
    if (requests.size() < kLanes) {
      std::array<SampleRequest, kLanes> padded{};
      std::copy(requests.begin(), requests.end(), padded.begin());
      return rays(padded, out);
    }
    const CameraPose& pose = camera_.poses.front();
    run_widest([&]() TRIAD_INLINE_BODY {
      // Copies that stores to the lanes cannot change, so that the loop needs no look at memory in between.
      const double width = width_, height = height_, half_width = half_width_, half_height = half_height_;
      const Double3 r = pose.right, u = pose.up, base = camera_.orthographic ? pose.position_m : pose.forward;
      const auto [x, y, z] = camera_.orthographic ? out.origins() : out.directions();
      // Vectors by hand: a compiler that sees places 40 bytes apart goes through them one by one.
      for (int i = 0; i < kLanes; i += 8) {
        const SampleRequest* q = &requests[static_cast<size_t>(i)];
        const Eight right{q[0].x, q[1].x, q[2].x, q[3].x, q[4].x, q[5].x, q[6].x, q[7].x};
        const Eight down{q[0].y, q[1].y, q[2].y, q[3].y, q[4].y, q[5].y, q[6].y, q[7].y};
        const Eight a = (2 * right / width - 1) * half_width, b = (1 - 2 * down / height) * half_height;
        const EightFloats along_x = __builtin_convertvector(base.x + (r.x * a + u.x * b), EightFloats);
        const EightFloats along_y = __builtin_convertvector(base.y + (r.y * a + u.y * b), EightFloats);
        const EightFloats along_z = __builtin_convertvector(base.z + (r.z * a + u.z * b), EightFloats);
        std::memcpy(x + i, &along_x, sizeof(along_x));
        std::memcpy(y + i, &along_y, sizeof(along_y));
        std::memcpy(z + i, &along_z, sizeof(along_z));
      }
    });
  }

  // x, y: film position; lens_u, lens_v in [0, 1): a point of the lens; time: 0 ... 1 over the shutter's time.
  Ray ray(double x, double y, float lens_u, float lens_v, float time) const {
    const CameraPose& pose = moves_ ? moved(time) : camera_.poses.front();
    const double right = (2 * x / width_ - 1) * half_width_, up = (1 - 2 * y / height_) * half_height_;
    Double3 origin{}, direction{0, 0, 1};  // along right, up, forward
    if (camera_.orthographic)
      origin = {right, up, 0};
    else
      direction = {right, up, 1};
    if (lens_) {
      // The lens, uniformly; the ray goes through the point where the plane in focus is met from its middle.
      const double focus = camera_.focus_distance_m;
      const Double3 target{origin.x + direction.x * focus, origin.y + direction.y * focus, focus};
      const double radius = camera_.aperture_radius_m * std::sqrt(static_cast<double>(lens_u));
      const double angle = 2 * std::numbers::pi * static_cast<double>(lens_v);
      origin.x += radius * std::cos(angle);
      origin.y += radius * std::sin(angle);
      direction = {target.x - origin.x, target.y - origin.y, focus};
    }
    const double size = std::sqrt(direction.x * direction.x + direction.y * direction.y + direction.z * direction.z);
    Ray ray;
    ray.origin = in_world(pose, origin, pose.position_m, 1);
    ray.direction = in_world(pose, direction, {}, 1 / size);
    ray.time = time;
    return ray;
  }

 private:
  typedef double Eight __attribute__((vector_size(64)));
  typedef float EightFloats __attribute__((vector_size(32)));

  static Float3 in_world(const CameraPose& pose, Double3 v, Double3 base, double scale) {
    return {static_cast<float>(base.x + scale * (pose.right.x * v.x + pose.up.x * v.y + pose.forward.x * v.z)),
            static_cast<float>(base.y + scale * (pose.right.y * v.x + pose.up.y * v.y + pose.forward.y * v.z)),
            static_cast<float>(base.z + scale * (pose.right.z * v.x + pose.up.z * v.y + pose.forward.z * v.z))};
  }
  static Double3 between(Double3 a, Double3 b, double t) {
    return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
  }
  static Double3 unit(Double3 a) {
    const double size = std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
    return {a.x / size, a.y / size, a.z / size};
  }
  CameraPose moved(float time) const {
    const double at = std::clamp(static_cast<double>(time), 0., 1.) * static_cast<double>(camera_.poses.size() - 1);
    const size_t step = std::min(static_cast<size_t>(at), camera_.poses.size() - 2);
    const CameraPose &a = camera_.poses[step], &b = camera_.poses[step + 1];
    const double t = at - static_cast<double>(step);
    CameraPose pose;
    pose.position_m = between(a.position_m, b.position_m, t);
    // Forward as it is between the two, the others made square to it.
    pose.forward = unit(between(a.forward, b.forward, t));
    const Double3 up = between(a.up, b.up, t), f = pose.forward;
    pose.right = unit({f.y * up.z - f.z * up.y, f.z * up.x - f.x * up.z, f.x * up.y - f.y * up.x});
    const Double3 r = pose.right;
    pose.up = {r.y * f.z - r.z * f.y, r.z * f.x - r.x * f.z, r.x * f.y - r.y * f.x};
    return pose;
  }

  const Camera& camera_;
  double width_, height_, half_width_ = 1, half_height_ = 1;
  bool lens_ = false, moves_ = false;
};

}  // namespace triad::raytracer
