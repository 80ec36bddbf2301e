# SPDX-License-Identifier: Apache-2.0
"""One description for every renderer: reads a glTF file of matt surfaces, one rectangular lamp and one camera, and

    python3 peers_scene.py povray SCENE.gltf OUT.pov       writes it as a POV-Ray scene with direct light
    blender -b --factory-startup -P peers_scene.py -- SCENE.gltf SEED BOUNCES SIZE OUT.exr=SPP...
                                                           draws it with Cycles, a picture for each OUT

The axes are glTF's in all of them: y is up, a camera looks along its own -z. Standard library only.
"""

import base64
import json
import math
import os
import struct
import sys

COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
FORMATS = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}


def multiply(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def node_matrix(node):
    """Rows; glTF stores columns."""
    if "matrix" in node:
        m = node["matrix"]
        return [[m[4 * column + row] for column in range(4)] for row in range(4)]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    rotation = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    scale, translation = node.get("scale", (1, 1, 1)), node.get("translation", (0, 0, 0))
    return [[rotation[i][j] * scale[j] for j in range(3)] + [translation[i]] for i in range(3)] + [[0, 0, 0, 1]]


def transformed(matrix, point, w=1):
    return tuple(sum(matrix[i][j] * point[j] for j in range(3)) + w * matrix[i][3] for i in range(3))


class Scene:
    """triangles: (corners, reflectance) of what does not shine; lamp: corner, two edges, unit normal, radiance;
    camera: matrix as rows, vertical angle in radians."""

    def __init__(self, path):
        self.folder = os.path.dirname(os.path.abspath(path))
        with open(path, encoding="utf-8") as file:
            self.gltf = json.load(file)
        self.buffers = [self.buffer(b["uri"]) for b in self.gltf["buffers"]]
        self.triangles, self.lamp, self.camera = [], None, None
        identity = [[float(i == j) for j in range(4)] for i in range(4)]
        for node in self.gltf["scenes"][self.gltf.get("scene", 0)]["nodes"]:
            self.visit(self.gltf["nodes"][node], identity)
        if self.lamp is None or self.camera is None:
            raise SystemExit(f"{path}: a lamp and a camera are needed")

    def buffer(self, uri):
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        with open(os.path.join(self.folder, uri), "rb") as file:
            return file.read()

    def accessor(self, index):
        accessor = self.gltf["accessors"][index]
        view = self.gltf["bufferViews"][accessor["bufferView"]]
        form = struct.Struct(f"<{COMPONENTS[accessor['type']]}{FORMATS[accessor['componentType']]}")
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", form.size)
        data = self.buffers[view["buffer"]]
        return [form.unpack_from(data, start + i * stride) for i in range(accessor["count"])]

    def visit(self, node, parent):
        matrix = multiply(parent, node_matrix(node))
        if "mesh" in node:
            for primitive in self.gltf["meshes"][node["mesh"]]["primitives"]:
                self.add(primitive, matrix)
        if "camera" in node and self.camera is None:
            self.camera = (matrix, self.gltf["cameras"][node["camera"]]["perspective"]["yfov"])
        for child in node.get("children", ()):
            self.visit(self.gltf["nodes"][child], matrix)

    def add(self, primitive, matrix):
        points = [transformed(matrix, p) for p in self.accessor(primitive["attributes"]["POSITION"])]
        indices = [i[0] for i in self.accessor(primitive["indices"])]
        material = self.gltf["materials"][primitive["material"]]
        surface, extensions = material["pbrMetallicRoughness"], material.get("extensions", {})
        if extensions.get("KHR_materials_ior", {}).get("ior", 1.5) != 1 or surface.get("metallicFactor", 1) != 0:
            raise SystemExit(f"material '{material['name']}' is not purely matt: ior 1 and metallicFactor 0 are")
        if "emissiveFactor" not in material:
            colour = tuple(surface["baseColorFactor"][:3])
            corners = [points[i] for i in indices]
            self.triangles += [(corners[i : i + 3], colour) for i in range(0, len(corners), 3)]
            return
        if self.lamp is not None or len(points) != 4:
            raise SystemExit("one lamp of four corners is needed")
        strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
        self.lamp = Lamp(points, indices, tuple(strength * e for e in material["emissiveFactor"]))


def difference(a, b):
    return tuple(x - y for x, y in zip(a, b))


def length(a):
    return math.sqrt(sum(x * x for x in a))


class Lamp:
    """A rectangle that shines from its front, where its corners run anticlockwise."""

    def __init__(self, points, indices, radiance):
        # The first triangle's corner with the right angle, and the edges that leave it.
        for turn in range(3):
            corner, a, b = (points[indices[(turn + i) % 3]] for i in range(3))
            edges = (difference(a, corner), difference(b, corner))
            if abs(sum(x * y for x, y in zip(*edges))) < 1e-9:
                break
        else:
            raise SystemExit("the lamp is not a rectangle")
        u, v = edges
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        self.area_m2 = length(normal)
        self.normal = tuple(n / self.area_m2 for n in normal)
        self.edges, self.radiance = edges, radiance
        self.corners = [corner] + [tuple(c + e for c, e in zip(corner, edge)) for edge in edges]
        self.middle = tuple(c + (a + b) / 2 for c, a, b in zip(corner, u, v))

    def triangles(self):
        a, b, d = self.corners
        c = tuple(x + y - z for x, y, z in zip(b, d, a))
        return [a, b, c, a, c, d]


# POV-Ray's attenuation is 2 / (1 + (d / fade_distance)^2): 2 (fade_distance / d)^2 where this is small beside d.
FADE_DISTANCE_M = 1e-3

POVRAY = """// Direct light from a lamp of uniform radiance. Parts comes from the command line.
#version 3.7;
global_settings {{ assumed_gamma 1.0 max_trace_level 1 }}
camera {{ perspective location {location} right {right} up {up} direction {direction} }}
// The lamp as Parts x Parts spotlights: tightness 1 is the lamp's own cosine, fade_power 2 the square of the
// distance. A matt surface reflects irradiance / pi, POV-Ray irradiance: hence a pi in the intensity. (An area_light
// has the cosines of its middle, or their mean times the visible part: wrong where a surface sees half of the lamp.)
#declare Edge1 = {u} / Parts;
#declare Edge2 = {v} / Parts;
#for (I, 1, Parts)
#for (J, 1, Parts)
#declare Middle = {corner} + (I - .5) * Edge1 + (J - .5) * Edge2;
light_source {{
  Middle, rgb {intensity} / (Parts * Parts)
  spotlight point_at Middle + {normal} radius 90 falloff 90 tightness 1
  fade_power 2 fade_distance {fade}
}}
#end
#end
"""


def pov_vector(v):
    return "<" + ", ".join(repr(float(x)) for x in v) + ">"


def write_povray(scene, path):
    matrix, yfov = scene.camera
    lamp, scale = scene.lamp, 2 * math.tan(yfov / 2)
    axis = [transformed(matrix, [float(i == j) for j in range(3)], 0) for i in range(3)]
    factor = lamp.area_m2 / math.pi / (2 * FADE_DISTANCE_M**2)
    text = POVRAY.format(
        location=pov_vector(transformed(matrix, (0, 0, 0))),
        right=pov_vector(scale * x for x in axis[0]),
        up=pov_vector(scale * x for x in axis[1]),
        direction=pov_vector(-x for x in axis[2]),
        corner=pov_vector(lamp.corners[0]),
        normal=pov_vector(lamp.normal),
        intensity=pov_vector(factor * r for r in lamp.radiance),
        fade=FADE_DISTANCE_M,
        u=pov_vector(lamp.edges[0]),
        v=pov_vector(lamp.edges[1]),
    )
    for corners, colour in scene.triangles:
        text += pov_triangle(corners, colour, "diffuse 1 emission 0")
    corners = lamp.triangles()
    for i in (0, 3):
        text += pov_triangle(corners[i : i + 3], lamp.radiance, "diffuse 0 emission 1", "no_shadow ")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def pov_triangle(corners, colour, finish, flags=""):
    points = ", ".join(pov_vector(c) for c in corners)
    return f"triangle {{ {points} pigment {{ rgb {pov_vector(colour)} }} finish {{ ambient 0 {finish} }} {flags}}}\n"


# So that the panel does not hide the light.
LIGHT_BEFORE_PANEL_M = 1e-4


def build_blender(bpy, scene):
    from mathutils import Matrix

    for block in list(bpy.data.objects):
        bpy.data.objects.remove(block, do_unlink=True)
    picture = bpy.context.scene
    world = bpy.data.worlds.new("black")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    picture.world = world

    def add(name, data):
        thing = bpy.data.objects.new(name, data)
        picture.collection.objects.link(thing)
        return thing

    def material(name, kind, colour):
        """One shader node: its output goes to the surface."""
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        shader, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
        shader.inputs["Color"].default_value = (*colour, 1)
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
        return made, tree, shader

    def mesh(name, corners, surface):
        data = bpy.data.meshes.new(name)
        data.from_pydata(corners, [], [(i, i + 1, i + 2) for i in range(0, len(corners), 3)])
        data.materials.append(surface)
        return add(name, data)

    for colour in sorted({colour for _, colour in scene.triangles}):
        corners = [c for triangle, own in scene.triangles if own == colour for c in triangle]
        mesh("matt", corners, material("matt", "ShaderNodeBsdfDiffuse", colour)[0])

    # What serves Cycles best, measured: it aims at an area light by solid angle, at a mesh by triangles, and matt
    # surfaces need no second strategy. A camera does not see such a light, hence a panel behind it that shines for
    # the camera and is black, as the lamp is, for all other rays.
    lamp = scene.lamp
    panel, tree, emission = material("panel", "ShaderNodeEmission", lamp.radiance)
    path = tree.nodes.new("ShaderNodeLightPath")
    tree.links.new(path.outputs["Is Camera Ray"], emission.inputs["Strength"])
    panel.cycles.sample_as_light = False
    mesh("panel", lamp.triangles(), panel)
    light = bpy.data.lights.new("lamp", "AREA")
    light.shape = "RECTANGLE"
    light.size, light.size_y = (length(e) for e in lamp.edges)
    strength = max(lamp.radiance)
    light.color = [r / strength for r in lamp.radiance]
    light.energy = 4 * lamp.area_m2 * strength  # watts by Cycles' convention
    light.cycles.use_multiple_importance_sampling = False
    u, v = ([x / length(e) for x in e] for e in lamp.edges)
    middle = [m + n * LIGHT_BEFORE_PANEL_M for m, n in zip(lamp.middle, lamp.normal)]
    # It shines along its own -z.
    rows = [[-u[i], v[i], -lamp.normal[i], middle[i]] for i in range(3)]
    add("lamp", light).matrix_world = Matrix(rows + [[0, 0, 0, 1]])

    matrix, yfov = scene.camera
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit = "VERTICAL"
    camera.angle_y = yfov
    camera.clip_start = 1e-3
    view = add("camera", camera)
    view.matrix_world = Matrix(matrix)
    picture.camera = view


def draw_cycles(bpy, seed, bounces, size, outputs):
    picture = bpy.context.scene
    render, cycles = picture.render, picture.cycles
    render.engine = "CYCLES"
    render.resolution_x = render.resolution_y = size
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", 2
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    picture.view_settings.view_transform = "Raw"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.pixel_filter_type = "BOX"  # one pixel wide, whatever filter_width says
    cycles.max_bounces = cycles.diffuse_bounces = bounces
    cycles.seed = seed
    for output in outputs:
        path, samples = output.rsplit("=", 1)
        cycles.samples = int(samples)
        render.filepath = path
        bpy.ops.render.render(write_still=True)


def main(arguments):
    if "--" in arguments:
        import bpy

        path, seed, bounces, size, *outputs = arguments[arguments.index("--") + 1 :]
        build_blender(bpy, Scene(path))
        draw_cycles(bpy, int(seed), int(bounces), int(size), outputs)
    elif len(arguments) == 4 and arguments[1] == "povray":
        write_povray(Scene(arguments[2]), arguments[3])
    else:
        raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv)
