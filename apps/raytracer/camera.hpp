// SPDX-License-Identifier: Apache-2.0
// From a place on the film to a ray.
#pragma once

#include <cmath>
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
    alignas(64) double right[kLanes] = {}, up[kLanes] = {};
    for (size_t i = 0; i < requests.size(); ++i) {
      right[i] = requests[i].x;
      up[i] = requests[i].y;
    }
    const CameraPose& pose = camera_.poses.front();
    run_widest([&]() TRIAD_INLINE_BODY {
      // Copies that stores to the lanes cannot change, so that the loop needs no look at memory in between.
      const double width = width_, height = height_, half_width = half_width_, half_height = half_height_;
      const Double3 r = pose.right, u = pose.up, base = camera_.orthographic ? pose.position_m : pose.forward;
      const auto [x, y, z] = camera_.orthographic ? out.origins() : out.directions();
      for (int i = 0; i < kLanes; ++i) {
        const double a = (2 * right[i] / width - 1) * half_width, b = (1 - 2 * up[i] / height) * half_height;
        x[i] = static_cast<float>(base.x + (r.x * a + u.x * b));
        y[i] = static_cast<float>(base.y + (r.y * a + u.y * b));
        z[i] = static_cast<float>(base.z + (r.z * a + u.z * b));
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
