# SPDX-License-Identifier: MIT OR Apache-2.0
"""Renders scenes with Turner and with Cycles, and compares the means of parts of the pictures.

Run by hand, with Blender's Python module: `pip install bpy==4.5.*` in a virtual environment of Python 3.11, then

    TURNER=target/release/turner python extras/blender/test_turner_render.py [--out FOLDER] [NAME ...]
"""

import argparse
import importlib.util
import math
import os
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

# Settings and add-ons of the user are left alone.
user_folder = tempfile.TemporaryDirectory(prefix="blender-user-")
os.environ["BLENDER_USER_RESOURCES"] = user_folder.name

import bpy
import numpy as np

import addon_utils  # Part of Blender, found once `bpy` is imported.

HERE = Path(__file__).resolve().parent
WIDTH, HEIGHT = 160, 120
failures = []
# Whether both programs denoise, for pictures to look at.
denoises = False


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
        socket.default_value = (*default, 1) if socket.type == "RGBA" else default
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


def soft_spot_scene():
    floor()
    mesh("cube", "Cube", (0, 0, 1), shader("grey", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.3, 0.2)), 1.2)
    light("SPOT", 800, (1.5, -2, 4), (30, 20, 10), spot_size=math.radians(70), spot_blend=0.3, shadow_soft_size=0.4)


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
    metal = material("metal", Metallic=1.0, Roughness=0.15, Base_Color=(0.9, 0.7, 0.4))
    three_balls(metal, shader("white", "ShaderNodeBsdfDiffuse"))
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


def sky_of(kind, **keys):
    """A sky texture in the world, over a floor with three balls. The camera does not see the sky itself."""
    mesh("plane", "Floor", used=shader("floor", "ShaderNodeBsdfDiffuse", Color=(0.5, 0.5, 0.5)), size=200)
    bpy.context.scene.camera.rotation_euler[0] = math.radians(58)
    metal = material("metal", Metallic=1.0, Roughness=0.15, Base_Color=(0.9, 0.7, 0.4))
    three_balls(metal, shader("white", "ShaderNodeBsdfDiffuse"))
    tree = bpy.context.scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sky_type = kind
    for key, value in keys.items():
        setattr(node, key, value)
    tree.links.new(node.outputs[0], background(0.0, 0.1).inputs["Color"])


def sky_scene():
    sky_of("NISHITA", sun_elevation=math.radians(35), sun_rotation=math.radians(130), dust_density=2.0)


def sky_without_sun_scene():
    sky_of("NISHITA", sun_elevation=math.radians(25), sun_rotation=2.0, sun_disc=False, altitude=500.0, ozone_density=2.0)


def older_sky_scene():
    sky_of("HOSEK_WILKIE", sun_direction=(0.5, -0.4, 0.6), turbidity=3.0)


def clip_scene():
    floor()
    mesh("cube", "Cube", (0, 0, 0.6), None, 1.2)
    background((0.3, 0.5, 0.8), 1.5)
    bpy.context.scene.camera.data.clip_end = 6.5


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


def still_life():
    """The picture of docs/guides/blender.md, with `--denoise`: gold, glass, lacquer and cloth under an area light."""
    ground = shader("ground", "ShaderNodeBsdfDiffuse", Color=(0.35, 0.33, 0.3))
    mesh("plane", "Floor", used=ground, size=30)
    gold = material("gold", Metallic=1.0, Roughness=0.18, Base_Color=(1.0, 0.72, 0.3))
    head = mesh("monkey", "Monkey", (0, 0.3, 0.98), gold, 2.0, (-22, 0, 12))
    head.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    bpy.ops.object.shade_smooth()
    mesh("sphere", "Glass", (1.75, -0.4, 0.6), material("glass", Transmission_Weight=1.0, Roughness=0.0, IOR=1.5), 1.2)
    lacquer = material("lacquer", Base_Color=(0.5, 0.02, 0.03), Roughness=0.5, Coat_Weight=1.0, Coat_Roughness=0.05)
    cube = mesh("cube", "Lacquer", (-1.85, -0.1, 0.5), lacquer, 1.0, (0, 0, 25))
    bevel = cube.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.08, 4
    cloth = material("cloth", Base_Color=(0.05, 0.12, 0.4), Roughness=0.9, Sheen_Weight=0.8, Specular_IOR_Level=0.2)
    mesh("sphere", "Cloth", (-0.75, -1.15, 0.3), cloth, 0.6)
    glow = material("glow", Base_Color=(0, 0, 0), Emission_Color=(0.3, 0.7, 1.0), Emission_Strength=2.0)
    mesh("sphere", "Glow", (0.75, -1.3, 0.22), glow, 0.44)
    background((0.32, 0.38, 0.5), 0.6)
    light("AREA", 320, (-3, -2.5, 4.2), (45, 0, -50), shape="RECTANGLE", size=2.2, size_y=1.4, color=(1, 0.93, 0.82))
    source = camera((0, -6.6, 2.1), (77, 0, 0), 42)
    source.data.dof.use_dof, source.data.dof.focus_distance, source.data.dof.aperture_fstop = True, 6.4, 1.2
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 480, 360


# Scene, largest difference of the means of the picture's twelfths in per cent of the mean of the picture.
SCENES = {
    "point": (point_scene, 3),
    "hard_point": (hard_point_scene, 2),
    "sun": (sun_scene, 2),
    "spot": (spot_scene, 2),
    "soft_spot": (soft_spot_scene, 2),
    "area": (area_scene, 2),
    "ellipse": (ellipse_scene, 2),
    # Turner cannot hide an emissive surface from the camera alone: the figures are printed, not judged.
    "visible": (visible_scene, math.inf),
    "world": (world_scene, 2),
    "environment": (environment_scene, 4),
    # Skies of different models: brightness and shadows agree, gradients do not.
    "sky": (sky_scene, 10),
    "sky_without_sun": (sky_without_sun_scene, 10),
    "older_sky": (older_sky_scene, 12),
    "clip": (clip_scene, 2),
    "materials": (materials_scene, 4),
    "plastics": (plastics_scene, 5),
    "shaders": (shaders_scene, 4),
    "wax": (wax_scene, 9),
    "texture": (texture_scene, 4),
    "instances": (instances_scene, 3),
    "animation": (animation_scene, 3),
    "lens": (lens_scene, 3),
    "parallel": (parallel_scene, 3),
    "panorama": (panorama_scene, 3),
    "still_life": (still_life, 6),
}


# ---------------------------------------------------------------------------------------------------------------------
# Rendering


def render(addon, engine, path, samples, file_format="OPEN_EXR"):
    """Renders to an OpenEXR file, through Blender's own output in both cases."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.image_settings.file_format = file_format
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.image_settings.color_mode = "RGBA"
    scene.render.filepath = str(path)
    if engine == "CYCLES":
        cycles = scene.cycles
        cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = samples, denoises, False
        cycles.sample_clamp_indirect = cycles.blur_glossy = 0
        cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 16
        cycles.pixel_filter_type = "BOX"
    else:
        scene.turner.samples, scene.turner.denoise = samples, "on" if denoises else "off"
        scene.turner.remove_fireflies = denoises
    bpy.ops.render.render(write_still=True)
    if file_format == "OPEN_EXR_MULTILAYER":
        return None
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
    found = f"mean {total:+.2f} %, largest difference of a twelfth {difference:.2f} % (< {bound})"
    check(name, difference < bound, found)


def check_passes(addon, folder, samples):
    """Depth, normal and albedo beside Cycles' passes, in the scene `plastics` with a transparent film."""
    plastics_scene()
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_diffuse_color = True
    bpy.context.scene.render.film_transparent = True
    found = {}
    for engine in ("TURNER", "CYCLES"):
        render(addon, engine, folder / f"passes_{engine}.exr", samples, "OPEN_EXR_MULTILAYER")
        channels = addon.read_exr(folder / f"passes_{engine}.exr")
        found[engine] = {name.split(".", 1)[1]: values for name, values in channels.items() if "." in name}
    turner, cycles = found["TURNER"], found["CYCLES"]
    albedo = next((n for n in cycles if n.startswith(("DiffCol", "Diffuse Color"))), "none").rsplit(".", 1)[0]
    alpha = np.abs(turner["Combined.A"] - cycles["Combined.A"]).mean()
    check("alpha", alpha < 0.005, f"mean difference {alpha:.5f}")
    solid = (turner["Combined.A"] == 1) & (cycles["Combined.A"] == 1)
    depth = np.median(np.abs(turner["Depth.Z"] - cycles["Depth.Z"])[solid])
    check("depth", depth < 0.02, f"median difference {depth:.5f} of {np.median(cycles['Depth.Z'][solid]):.2f}")
    for axis in "XYZ":
        normal = np.abs(turner[f"Normal.{axis}"] - cycles[f"Normal.{axis}"])[solid].mean()
        check(f"normal {axis}", normal < 0.03, f"mean difference {normal:.5f}")
    color = np.median(np.abs(turner[f"{albedo}.R"] - cycles[f"{albedo}.R"])[solid])
    check("albedo", color < 0.02, f"median difference {color:.5f}")


def check_border(addon, folder):
    """A border renders a part of the frame, with the pixels of the whole one."""
    area_scene()
    whole = render(addon, "TURNER", folder / "whole.exr", 4)
    frame = bpy.context.scene.render
    frame.use_border, frame.use_crop_to_border = True, True
    frame.border_min_x, frame.border_max_x, frame.border_min_y, frame.border_max_y = 0.25, 0.75, 0.5, 1.0
    part = render(addon, "TURNER", folder / "part.exr", 4)
    same = part.shape[:2] == (60, 80) and np.array_equal(part, whole[:60, 40:120])
    check("border", same, f"{part.shape[:2]}")
    frame.use_crop_to_border = False
    part = render(addon, "TURNER", folder / "part.exr", 4)
    same = part.shape == whole.shape and np.array_equal(part[:60, 40:120, :3], whole[:60, 40:120, :3])
    check("border without crop", same, f"{part.shape[:2]}")


def check_errors(addon, folder):
    """One clear message: without the program, without a camera, and where the program fails."""
    floor()
    old = os.environ.get("TURNER")
    scene = bpy.context.scene
    for name, program, source, expected in (
        ("no program", str(folder / "missing"), scene.camera, "was not found"),
        ("failing program", sys.executable, scene.camera, "wrote no picture"),
        ("no camera", old, None, "camera"),
    ):
        os.environ["TURNER"], scene.camera = program or "", source
        try:
            render(addon, "TURNER", folder / "error.exr", 4)
            message = "no error"
        except RuntimeError as error:
            message = str(error).strip()
        check(name, expected in message, message)
    os.environ.pop("TURNER")
    if old is not None:
        os.environ["TURNER"] = old


def check_export(addon, folder):
    """The operator writes a scene that the program renders alone; the scene in Blender stays as it was."""
    animation_scene()
    cube = bpy.data.objects["Cube"]
    before = len(cube.modifiers), bpy.context.scene.frame_current
    result = bpy.ops.turner.export(directory=str(folder / "exported"))
    after = len(cube.modifiers), bpy.context.scene.frame_current
    check("export", result == {"FINISHED"} and before == after, f"{result}, {before} {after}")
    command = [addon.find_turner(), "render", str(folder / "exported" / "scene.toml"), "--strict", "--quiet"]
    done = subprocess.run(command + ["--samples", "2", "-o", str(folder / "exported.png")], capture_output=True)
    check("render of the export", done.returncode == 0, done.stderr.decode().strip() or "ok")


def check_cancel(addon, folder):
    """A render that is cancelled leaves the picture so far."""
    area_scene()
    bpy.context.scene.turner.samples = 1 << 20
    bpy.ops.turner.export(directory=str(folder / "cancelled"))
    picture = folder / "cancelled.exr"
    picture.unlink(missing_ok=True)
    scene_file = folder / "cancelled" / "scene.toml"
    process = addon.Process(addon.arguments(addon.find_turner(), scene_file, picture, bpy.context.scene.turner))
    running = not process.finished(3.0)
    process.cancel()
    shape = addon.passes(addon.read_exr(picture))["Combined"].shape if picture.is_file() else None
    check("cancel", running and shape == (HEIGHT, WIDTH, 4), f"running {running}, progress {process.done}, {shape}")


def check_install(addon, folder):
    """The file installs as an add-on, and its preferences hold the program."""
    addon.unregister()
    del sys.modules["turner_render"]
    sys.path[:] = [p for p in sys.path if Path(p).resolve() != HERE]
    bpy.ops.preferences.addon_install(filepath=str(HERE / "turner_render.py"), overwrite=True)
    bpy.ops.preferences.addon_enable(module="turner_render")
    installed = sys.modules["turner_render"]
    entry = bpy.context.preferences.addons["turner_render"].preferences
    entry.executable = sys.executable
    chosen = installed.find_turner()
    is_copy = Path(installed.__file__).parent != HERE
    check("install", is_copy and chosen == sys.executable, f"{installed.__file__}, {chosen}")
    entry.executable = str(folder / "missing")
    check("wrong program", installed.find_turner() is None, f"{installed.find_turner()}")
    bpy.ops.preferences.addon_disable(module="turner_render")
    addon.register()


def check_materials(addon, folder):
    """Single functions with closed forms."""
    close = lambda a, b: abs(a - b) < 1e-6
    check("no wax", close(addon.mean_free_path(0.0, 1.4), math.sqrt(3.0)), addon.mean_free_path(0.0, 1.4))
    check("white wax", addon.mean_free_path(1.0, 1.4) < 1e-3, addon.mean_free_path(1.0, 1.4))
    check("level", close(addon.scaled_ior(1.5, 1.0), 1.5) and close(addon.scaled_ior(1.5, 0.0), 1.0), "ok")
    check("doubled F0", close(addon.scaled_ior(1.5, 2.0), (1 + 0.08**0.5) / (1 - 0.08**0.5)), "ok")
    roughness, b = addon.anisotropic(0.4, 0.5)
    x = roughness**2 * math.sqrt(2 / (1 + (1 - b) ** 2))
    aspect = math.sqrt(1 - 0.9 * 0.5)
    check("anisotropy", close(x, 0.16 / aspect) and close((1 - b) * x, 0.16 * aspect), f"{x} {(1 - b) * x}")
    text = addon.toml({"a b": [1, 2.5, True, 'q"\n'], "c": {"d": 1e-9}})
    check("TOML", tomllib.loads("x = " + text)["x"] == {"a b": [1, 2.5, True, 'q"\n'], "c": {"d": 1e-9}}, text)


CHECKS = {
    "passes": check_passes,
    "border": check_border,
    "errors": check_errors,
    "export": check_export,
    "cancel": check_cancel,
    "install": check_install,
    "values": check_materials,
}


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
    parser.add_argument("--denoise", action="store_true")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    global denoises
    denoises = options.denoise
    folder = Path(options.out or tempfile.mkdtemp(prefix="turner-blender-"))
    folder.mkdir(parents=True, exist_ok=True)
    for name, (build, bound) in SCENES.items():
        if options.names and name not in options.names:
            continue
        addon = empty_scene()
        build()
        compare(name, addon, bound, folder, options.samples)
        addon.unregister()
    for name, run in CHECKS.items():
        if options.names and name not in options.names:
            continue
        addon = empty_scene()
        run(addon, folder, *([options.samples] if name == "passes" else []))
        addon.unregister()
    print(f"pictures in {folder}; {len(failures)} failures")
    for line in failures:
        print("  " + line)
    sys.exit(1 if failures else 0)


main()
