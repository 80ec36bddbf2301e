// SPDX-License-Identifier: Apache-2.0
// Scenes from glTF 2.0 files (.gltf and .glb).
#pragma once

#include <functional>
#include <string>

#include "scene.hpp"

namespace triad::raytracer {

struct LoadOptions {
  std::string camera;  // by name or by number from 0; "" the first in the scene
  // Told how much is done, 0 to 1, never less than before; from the thread that loads.
  std::function<void(double)> progress{};
};

// Reads a scene with its buffers and pictures; which of the two formats it is, its first bytes tell.
//
// Understood: triangles in lists, strips and fans; sparse and quantised accessors; metallic-roughness materials;
// KHR_lights_punctual, KHR_materials_emissive_strength, KHR_materials_ior, KHR_materials_transmission,
// KHR_materials_unlit, KHR_mesh_quantization, KHR_texture_transform; node animations over the camera's shutter
// time (enough steps that straight lines between them stray by less than 1e-3 of a mesh's size).
//
// Extras: a camera (or its node) may say "aperture_radius_m", "focus_distance_m" and "shutter_s": [open, close]
// or a duration from 0; a scene "background": [r, g, b], the radiance of what lies behind everything, or
// "environment": "file" with a factor "environment_strength".
//
// A scene whose coordinates are large beside its size is moved to Scene::origin_m, with a warning. A scene
// without a camera gets one that frames it. What is left out (normal maps, skins, points and lines, unknown
// extensions that are not required) is a warning in Scene::warnings; nothing is printed.
//
// Throws Error(kInput), naming the file: missing, not glTF, cut short, unknown required extension, an index or
// accessor out of bounds, a number that is not finite, a node that is its own ancestor, a missing picture,
// nothing to draw; Error(kUsage) for a camera that is not there; Error(kCancelled).
Scene load_gltf(const std::string& path, const LoadOptions& options = {});

}  // namespace triad::raytracer
