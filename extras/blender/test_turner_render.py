# SPDX-License-Identifier: MIT OR Apache-2.0
"""Renders scenes with Turner and with Cycles, and compares the means of parts of the pictures.

Run by hand, with Blender's Python module: `pip install bpy==4.5.*` in a virtual environment of Python 3.11, then

    TURNER=target/release/turner python extras/blender/test_turner_render.py [--out FOLDER] [NAME ...]
"""

import argparse
import importlib.util
import math
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

import addon_utils  # Part of Blender, found once `bpy` is imported.

HERE = Path(__file__).resolve().parent
WIDTH, HEIGHT = 160, 120
failures = []


def load_addon():
    spec = importlib.util.spec_from_file_location("turner_render", HERE / "turner_render.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["turner_render"] = module
    spec.loader.exec_module(module)
    return module


def check(name, holds, found):
    print(f"  {'ok  ' if holds else 'FAIL'} {name}: {found}")
    if not holds:
        failures.append(f"{name}: {found}")


# ---------------------------------------------------------------------------------------------------------------------
# Scenes


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("cycles")
    addon_utils.enable("io_scene_gltf2")
    addon = load_addon()
    addon.register()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.view_settings.view_transform = "Standard"
    world = bpy.data.worlds.new("World")
    scene.world = world
    world.use_nodes = True
    background(0.0)
    camera((0, -6, 3), (70, 0, 0))
    return addon


def background(color, strength=1.0):
    node = bpy.context.scene.world.node_tree.nodes["Background"]
    color = color if isinstance(color, tuple) else (color,) * 3
    node.inputs["Color"].default_value = (*color, 1)
    node.inputs["Strength"].default_value = strength
    return node


def add(name, data, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    source = bpy.data.objects.new(name, data)
    source.location, source.scale = location, scale
    source.rotation_euler = [math.radians(a) for a in rotation]
    bpy.context.scene.collection.objects.link(source)
    return source


def camera(location, rotation, lens=35):
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    source = add("Camera", data, location, rotation)
    bpy.context.scene.camera = source
    return source


def light(kind, energy, location, rotation=(0, 0, 0), **keys):
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = energy
    for key, value in keys.items():
        setattr(data, key, value)
    return add(kind.title(), data, location, rotation)


def material(name, **inputs):
    value = bpy.data.materials.new(name)
    value.use_nodes = True
    node = value.node_tree.nodes["Principled BSDF"]
    for key, default in inputs.items():
        socket = node.inputs[key.replace("_", " ")]
        socket.default_value = (*default, 1) if isinstance(default, tuple) and len(default) == 3 and socket.type == "RGBA" else default
    return value


def shader(name, kind, **inputs):
    """A material of one node."""
    value = bpy.data.materials.new(name)
    value.use_nodes = True
    tree = value.node_tree
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    node = tree.nodes.new(kind)
    for key, default in inputs.items():
        socket = node.inputs[key]
        socket.default_value = (*default, 1) if isinstance(default, tuple) else default
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return value


def mesh(kind, name, location=(0, 0, 0), used=None, size=2.0, rotation=(0, 0, 0), scale=(1, 1, 1)):
    if kind == "plane":
        bpy.ops.mesh.primitive_plane_add(size=size)
    elif kind == "cube":
        bpy.ops.mesh.primitive_cube_add(size=size)
    elif kind == "sphere":
        bpy.ops.mesh.primitive_uv_sphere_add(radius=size / 2, segments=48, ring_count=24)
        bpy.ops.object.shade_smooth()
    else:
        bpy.ops.mesh.primitive_monkey_add(size=size)
    source = bpy.context.object
    source.name = name
    source.location, source.scale = location, scale
    source.rotation_euler = [math.radians(a) for a in rotation]
    if used:
        source.data.materials.append(used)
    return source


def floor(color=(0.5, 0.5, 0.5)):
    return mesh("plane", "Floor", used=shader("floor", "ShaderNodeBsdfDiffuse", Color=color), size=20)


def three_balls(*used):
    for i, one in enumerate(used):
        mesh("sphere", f"Ball{i}", (2.0 * (i - (len(used) - 1) / 2), 0, 0.8), one, 1.6)


def point_scene():
    floor()
    mesh("cube", "Cube", (0, 0, 1), shader("grey", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.3, 0.2)), 1.2)
    light("POINT", 500, (2, -2, 4), shadow_soft_size=0.3, color=(1, 0.9, 0.7))


def hard_point_scene():
    floor()
    mesh("cube", "Cube", (0, 0, 1), shader("grey", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.3, 0.2)), 1.2)
    light("POINT", 500, (2, -2, 4), shadow_soft_size=0.0)


def sun_scene():
    floor()
    mesh("cube", "Cube", (0, 0, 0.6), None, 1.2)
    light("SUN", 3, (0, 0, 5), (40, 10, 30), angle=math.radians(5))


def spot_scene():
    floor()
    light("SPOT", 800, (0, 0, 5), (10, 5, 0), spot_size=math.radians(50), spot_blend=0.4, shadow_soft_size=0)


def area_scene():
    floor()
    mesh("cube", "Cube", (0, 0, 1), shader("grey", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.3, 0.2)), 1.2)
    light("AREA", 300, (1, 0, 4), (0, 15, 0), shape="RECTANGLE", size=2, size_y=0.5)


def ellipse_scene():
    floor()
    mesh("cube", "Cube", (0, 0, 1), material("plastic", Base_Color=(0.1, 0.3, 0.6), Roughness=0.3), 1.2)
    light("AREA", 300, (1, 0, 4), (0, 15, 0), shape="ELLIPSE", size=2, size_y=1)


def visible_scene():
    """Area light and ball light in the picture: invisible to the camera, visible in the mirror."""
    floor()
    background(0.2)
    mesh("cube", "Mirror", (0, 2, 1), material("mirror", Metallic=1.0, Roughness=0.05), 2, scale=(2, 0.1, 1))
    light("AREA", 100, (-1.5, 0.5, 1.5), (-110, 0, 0), size=1)
    light("POINT", 60, (1.5, 0, 1), shadow_soft_size=0.4)


def world_scene():
    floor()
    mesh("cube", "Cube", (0, 0, 0.6), None, 1.2)
    background((0.3, 0.5, 0.8), 1.5)


def environment_scene():
    floor()
    three_balls(material("metal", Metallic=1.0, Roughness=0.15, Base_Color=(0.9, 0.7, 0.4)), shader("white", "ShaderNodeBsdfDiffuse"))
    node = background(0.0, 0.8)
    tree = bpy.context.scene.world.node_tree
    image = bpy.data.images.new("sky", 64, 32, float_buffer=True)
    pixels = np.zeros((32, 64, 4), np.float32)
    pixels[..., 3] = 1
    pixels[16:, :, 2] = 0.6
    pixels[:16, :, 1] = 0.2
    pixels[20:26, 8:14, :3] = (30, 24, 12)
    pixels[14:20, 40:44, :3] = (6, 0, 0)
    image.pixels.foreach_set(pixels.ravel())
    picture = tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = image
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0, 0, math.radians(50))
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], picture.inputs["Vector"])
    tree.links.new(picture.outputs[0], node.inputs["Color"])


def materials_scene():
    floor()
    background(0.4)
    three_balls(
        material("gold", Metallic=1.0, Roughness=0.25, Base_Color=(1.0, 0.75, 0.3)),
        material("glass", Transmission_Weight=1.0, Roughness=0.0, IOR=1.45, Base_Color=(0.7, 0.95, 0.8)),
        material("lamp", Emission_Color=(1, 0.4, 0.1), Emission_Strength=3.0, Base_Color=(0, 0, 0)),
    )
    light("AREA", 200, (-2, -2, 4), (30, -20, 0), size=1)


def plastics_scene():
    floor()
    background(0.4)
    three_balls(
        material("plastic", Roughness=0.4, Base_Color=(0.8, 0.1, 0.1)),
        material("lacquer", Base_Color=(0.05, 0.2, 0.6), Roughness=0.6, Coat_Weight=1.0, Coat_Roughness=0.05),
        material("cloth", Base_Color=(0.3, 0.1, 0.4), Roughness=0.9, Sheen_Weight=1.0, Specular_IOR_Level=0.0),
    )
    light("AREA", 200, (-2, -2, 4), (30, -20, 0), size=1)


def shaders_scene():
    floor()
    background(0.4)
    three_balls(
        shader("glossy", "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.6, 0.5), Roughness=0.3),
        shader("glass", "ShaderNodeBsdfGlass", Color=(0.9, 0.95, 1.0), Roughness=0.2, IOR=1.5),
        shader("glow", "ShaderNodeEmission", Color=(0.2, 0.6, 1.0), Strength=2.0),
    )
    light("AREA", 200, (-2, -2, 4), (30, -20, 0), size=1)


def wax_scene():
    floor()
    background(0.4)
    three_balls(
        material("wax", Base_Color=(0.8, 0.6, 0.4), Subsurface_Weight=1.0, Subsurface_Scale=0.1, Roughness=0.5),
        material("half", Base_Color=(0.2, 0.6, 0.3), Alpha=0.5),
    )
    light("AREA", 200, (-2, -2, 4), (30, -20, 0), size=1)


def texture_scene():
    """A textured Principled BSDF, which travels by glTF, and a textured Diffuse BSDF, which does not."""
    floor()
    background(0.5)
    image = bpy.data.images.new("checks", 16, 16)
    pixels = np.ones((16, 16, 4), np.float32)
    pixels[::2, ::2, :3] = pixels[1::2, 1::2, :3] = (0.8, 0.2, 0.1)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    plastic, plain = material("plastic", Roughness=0.5), shader("plain", "ShaderNodeBsdfDiffuse")
    for one, socket in ((plastic, "Base Color"), (plain, "Color")):
        node = one.node_tree.nodes.new("ShaderNodeTexImage")
        node.image, node.interpolation = image, "Closest"
        target = next(n for n in one.node_tree.nodes if n.type in {"BSDF_PRINCIPLED", "BSDF_DIFFUSE"})
        one.node_tree.links.new(node.outputs[0], target.inputs[socket])
    mesh("cube", "Left", (-1.3, 0, 0.8), plastic, 1.6, (0, 0, 20))
    mesh("cube", "Right", (1.3, 0, 0.8), plain, 1.6, (0, 0, 20))
    light("SUN", 2, (0, 0, 5), (30, 20, 0))


def instances_scene():
    """Collection instances with a light in them, a subdivision modifier, a hidden object, an excluded collection."""
    floor()
    background(0.3)
    part = bpy.data.collections.new("Part")
    cube = mesh("cube", "Rounded", (0, 0, 0.7), material("red", Base_Color=(0.7, 0.1, 0.1)), 1)
    modifier = cube.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 3
    bpy.context.collection.objects.unlink(cube)
    part.objects.link(cube)
    lamp = light("POINT", 40, (0, -1, 1.5), shadow_soft_size=0.1)
    bpy.context.scene.collection.objects.unlink(lamp)
    part.objects.link(lamp)
    for i in range(3):
        source = add(f"Instance{i}", None, (2 * i - 2, 0, 0), (0, 0, 30 * i), (1, 1, 1 + 0.3 * i))
        source.instance_type, source.instance_collection = "COLLECTION", part
    hidden = mesh("cube", "Hidden", (0, -1, 1), None, 2)
    hidden.hide_render = True
    excluded = bpy.data.collections.new("Excluded")
    bpy.context.scene.collection.children.link(excluded)
    other = mesh("cube", "Other", (1, -1, 1), None, 2)
    bpy.context.scene.collection.objects.unlink(other)
    excluded.objects.link(other)
    bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True


def animation_scene():
    """Frame 7 of a moving, armature-free animation with a shape key."""
    floor()
    background(0.5)
    cube = mesh("cube", "Cube", (0, 0, 0.7), material("blue", Base_Color=(0.1, 0.2, 0.7)), 1.2)
    cube.location.x = -2
    cube.keyframe_insert("location", frame=1)
    cube.location.x = 2
    cube.keyframe_insert("location", frame=11)
    cube.shape_key_add(name="Basis")
    key = cube.shape_key_add(name="Tall")
    for point in key.data:
        point.co.z *= 2 if point.co.z > 0 else 1
    key.value = 1.0
    light("SUN", 2, (0, 0, 5), (30, 20, 0))
    bpy.context.scene.frame_set(7)


def lens_scene():
    """Depth of field, lens shift and a sensor fitted to its height."""
    floor((0.3, 0.3, 0.3))
    background(0.5)
    for i in range(5):
        glow = shader(f"c{i}", "ShaderNodeEmission", Color=(0.2 * i, 0.5, 1 - 0.2 * i), Strength=1.0)
        mesh("cube", f"Cube{i}", (i - 2, 1.5 * i - 2, 0.5), glow, 0.8)
    data = bpy.context.scene.camera.data
    data.sensor_fit, data.sensor_height, data.shift_x, data.shift_y = "VERTICAL", 24, 0.1, -0.15
    data.dof.use_dof, data.dof.aperture_fstop, data.dof.focus_distance = True, 0.05, 6.0


def parallel_scene():
    """An orthographic camera with a shift, and non-square pixels."""
    floor((0.3, 0.3, 0.3))
    background(0.5)
    mesh("monkey", "Monkey", (0, 0, 1), shader("m", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.4, 0.2)), 2)
    data = bpy.context.scene.camera.data
    data.type, data.ortho_scale, data.shift_x, data.shift_y = "ORTHO", 7, 0.1, 0.05
    bpy.context.scene.render.pixel_aspect_x = 1.5


def panorama_scene():
    floor((0.3, 0.3, 0.3))
    background((0.2, 0.4, 0.6))
    mesh("cube", "A", (0, 3, 1), shader("a", "ShaderNodeEmission", Color=(1, 0.2, 0.2)), 2)
    mesh("cube", "B", (3, -6, 1), shader("b", "ShaderNodeEmission", Color=(0.2, 1, 0.2)), 2)
    source = camera((0, -6, 3), (90, 0, 30))
    source.data.type = "PANO"
    settings = source.data if hasattr(source.data, "panorama_type") else source.data.cycles
    settings.panorama_type = "EQUIRECTANGULAR"


# Scene, largest difference of the means of the picture's twelfths in per cent of the mean of the picture.
SCENES = {
    "point": (point_scene, 2),
    "hard_point": (hard_point_scene, 2),
    "sun": (sun_scene, 2),
    "spot": (spot_scene, 2),
    "area": (area_scene, 2),
    "ellipse": (ellipse_scene, 2),
    "visible": (visible_scene, 3),
    "world": (world_scene, 2),
    "environment": (environment_scene, 4),
    "materials": (materials_scene, 4),
    "plastics": (plastics_scene, 4),
    "shaders": (shaders_scene, 4),
    "wax": (wax_scene, 4),
    "texture": (texture_scene, 4),
    "instances": (instances_scene, 3),
    "animation": (animation_scene, 3),
    "lens": (lens_scene, 3),
    "parallel": (parallel_scene, 3),
    "panorama": (panorama_scene, 3),
}


# ---------------------------------------------------------------------------------------------------------------------
# Rendering


def render(addon, engine, path, samples):
    """Renders to an OpenEXR file, through Blender's own output in both cases."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.image_settings.color_mode = "RGBA"
    scene.render.filepath = str(path)
    if engine == "CYCLES":
        cycles = scene.cycles
        cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = samples, False, False
        cycles.sample_clamp_indirect = cycles.blur_glossy = 0
        cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 16
        cycles.pixel_filter_type = "BOX"
    else:
        scene.turner.samples, scene.turner.denoise, scene.turner.remove_fireflies = samples, "off", False
    bpy.ops.render.render(write_still=True)
    channels = addon.read_exr(path)
    return np.dstack([channels[c] for c in "RGBA"])[::-1]


def twelfths(picture):
    """Means of 4 x 3 parts."""
    height, width = picture.shape[:2]
    return picture[..., :3].reshape(3, height // 3, 4, width // 4, 3).mean(axis=(1, 3))


def compare(name, addon, bound, folder, samples):
    turner = render(addon, "TURNER", folder / f"{name}_turner.exr", samples)
    cycles = render(addon, "CYCLES", folder / f"{name}_cycles.exr", samples)
    side_by_side(turner, cycles, folder / f"{name}.png")
    mean = cycles[..., :3].mean()
    difference = 100 * np.abs(twelfths(turner) - twelfths(cycles)).max() / mean
    total = 100 * (turner[..., :3].mean() / mean - 1)
    check(name, difference < bound, f"mean {total:+.2f} %, largest difference of a twelfth {difference:.2f} % (< {bound})")


def side_by_side(left, right, path):
    """Turner on the left, Cycles on the right."""
    both = np.concatenate([left, right], axis=1)
    both[..., 3] = 1
    image = bpy.data.images.new("both", both.shape[1], both.shape[0], float_buffer=True)
    image.pixels.foreach_set(np.ascontiguousarray(both[::-1], np.float32).ravel())
    scene = bpy.context.scene
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "PNG", "8"
    image.save_render(str(path), scene=scene)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out")
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    folder = Path(options.out or tempfile.mkdtemp(prefix="turner-blender-"))
    folder.mkdir(parents=True, exist_ok=True)
    for name, (build, bound) in SCENES.items():
        if options.names and name not in options.names:
            continue
        addon = empty_scene()
        build()
        compare(name, addon, bound, folder, options.samples)
        addon.unregister()
    print(f"pictures in {folder}; {len(failures)} failures")
    for line in failures:
        print("  " + line)
    sys.exit(1 if failures else 0)


main()
