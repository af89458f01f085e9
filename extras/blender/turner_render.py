# SPDX-License-Identifier: MIT OR Apache-2.0
"""Renders Blender scenes with Turner.

The objects travel as glTF (`scene.glb`, written by Blender's own exporter). What glTF cannot carry is written beside it
in Turner's scene format (`scene.toml`): camera with lens and shift, lights with their sizes, world, and materials
without textures. The program `turner` renders both to an OpenEXR file, whose channels become Blender's passes.

Blender has +z up, Turner +y: (x, y, z) becomes (x, z, -y).
"""

bl_info = {
    "name": "Turner",
    "author": "The Turner authors",
    "version": (0, 1, 0),
    "blender": (4, 2, 0),
    "location": "Render properties > Render Engine",
    "description": "Renders the scene with Turner",
    "category": "Render",
}

import json
import math
import os
import shutil
import struct
import subprocess
import tempfile
import threading
from pathlib import Path

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from mathutils import Matrix, Vector

TO_TURNER = Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))
MISSING = (
    "The program `turner` was not found. Set its path in Preferences > Add-ons > Turner, or put it on the PATH"
)


# ---------------------------------------------------------------------------------------------------------------------
# Turner's scene format


def toml(value):
    """A value in TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"a number of the scene is {value}")
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{toml(k)} = {toml(v)}" for k, v in value.items()) + " }"
    return "[" + ", ".join(toml(v) for v in value) + "]"


def toml_section(header, values):
    return "\n".join([header] + [f"{key} = {toml(value)}" for key, value in values.items()]) + "\n"


def vector(v):
    """A Blender vector in Turner's axes."""
    return [float(v[0]), float(v[2]), float(-v[1])]


def rgb(color):
    """The first three components of a linear colour. Negative ones have no meaning."""
    return [max(float(c), 0.0) for c in color[:3]]


class Report:
    """What the picture will not show, each sentence once."""

    def __init__(self):
        self.lines = []

    def note(self, line):
        if line not in self.lines:
            self.lines.append(line)


class Folder:
    """The folder of one scene, and the images that were written to it."""

    def __init__(self, path, report):
        self.path = Path(path)
        self.report = report
        self.images = {}

    def image(self, image):
        """The name of a file in this folder with the image; `None` if it has no pixels."""
        if image is None:
            return None
        if image.name not in self.images:
            self.images[image.name] = self._write(image, f"image{len(self.images)}")
        return self.images[image.name]

    def _write(self, image, stem):
        known = {".png", ".jpg", ".jpeg", ".webp", ".tga", ".bmp", ".exr", ".hdr"}
        source = Path(bpy.path.abspath(image.filepath_raw or image.filepath, library=image.library))
        name = stem + source.suffix.lower()
        unchanged = image.source == "FILE" and source.suffix.lower() in known and not image.is_dirty
        try:
            if unchanged and image.packed_file is not None:
                (self.path / name).write_bytes(image.packed_file.data)
                return name
            if unchanged and source.is_file():
                shutil.copyfile(source, self.path / name)
                return name
            if not image.has_data and len(image.pixels) == 0:
                raise RuntimeError("it has no pixels")
            return self._write_pixels(image, stem + ".pfm")
        except (OSError, RuntimeError) as error:
            self.report.note(f"The image “{image.name}” is missing: {error}")
            return None

    def _write_pixels(self, image, name):
        """Linear pixels as PFM, which stores rows from bottom to top as Blender does."""
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(height, width, image.channels)
        color = pixels[..., :3] if image.channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
        if not image.is_float and image.colorspace_settings.name == "sRGB":
            color = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
        with open(self.path / name, "wb") as file:
            file.write(f"PF\n{width} {height}\n-1.0\n".encode())
            file.write(np.ascontiguousarray(color, "<f4").tobytes())
        return name


# ---------------------------------------------------------------------------------------------------------------------
# Camera


def camera_section(depsgraph, camera, width, height, report):
    scene, data = depsgraph.scene_eval, camera.data
    matrix = camera.matrix_world.normalized()
    position, forward = matrix.translation, matrix.to_3x3() @ Vector((0, 0, -1))
    up = matrix.to_3x3() @ Vector((0, 1, 0))
    section = {
        "position": vector(position),
        "look_at": vector(position + forward),
        "up": vector(up),
        "near": float(data.clip_start),
        "far": float(data.clip_end),
    }
    if data.type == "PANO":
        return {**section, **panorama(data, report)}
    render = scene.render
    projection = camera.calc_matrix_camera(
        depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y
    )
    viewport = [2.0 / projection[0][0], 2.0 / projection[1][1]]
    if data.type == "ORTHO":
        # The shift of a parallel projection moves the camera.
        right = matrix.to_3x3() @ Vector((1, 0, 0))
        offset = -0.5 * (right * viewport[0] * projection[0][3] + up * viewport[1] * projection[1][3])
        section["position"] = vector(position + offset)
        section["look_at"] = vector(position + offset + forward)
        if data.dof.use_dof:
            report.note("Depth of field of orthographic cameras is ignored")
        return {"type": "orthographic", **section, "viewport": viewport}
    section |= {
        "viewport": viewport,
        "distance": 1.0,
        "shift": [0.5 * projection[0][2], 0.5 * projection[1][2]],
    }
    lens = lens_keys(camera, matrix, report) if data.dof.use_dof else None
    return {"type": "thin-lens", **section, **lens} if lens else {"type": "pinhole", **section}


def lens_keys(camera, matrix, report):
    """Depth of field. As in Cycles the diameter is focal length / f-stop, with 1000 mm to a scene unit."""
    data = camera.data
    dof = data.dof
    distance = dof.focus_distance
    if dof.focus_object is not None:
        target = dof.focus_object.matrix_world.translation
        distance = abs((matrix.inverted() @ target).z)
    if dof.aperture_fstop <= 0.0:
        return None
    if dof.aperture_ratio != 1.0:
        report.note("The aperture ratio (anamorphic bokeh) is ignored")
    blades = dof.aperture_blades if dof.aperture_blades >= 3 else 0
    return {
        "lens_radius": data.lens * 1e-3 / (2.0 * dof.aperture_fstop),
        "focus_distance": max(distance, 1e-5),
        "blades": blades,
        # Cycles has a corner on the right, Turner at the top.
        "blade_rotation": math.degrees(dof.aperture_rotation) - 90.0,
    }


def panorama(data, report):
    # The settings moved from Cycles' properties to the camera in Blender 5.0.
    settings = data if hasattr(data, "panorama_type") else getattr(data, "cycles", None)
    kind = getattr(settings, "panorama_type", "EQUIRECTANGULAR")
    if kind == "FISHEYE_EQUIDISTANT":
        return {"type": "fisheye", "fov": math.degrees(settings.fisheye_fov)}
    if kind != "EQUIRECTANGULAR":
        report.note(f"The panorama type {kind} is shown as an equirectangular panorama")
    return {"type": "equirectangular"}


# ---------------------------------------------------------------------------------------------------------------------
# Lights


def light_color(light, report):
    """Colour and factor of a light: temperature, exposure, and the constants of an emission node."""
    color, factor = rgb(light.color), 1.0
    if getattr(light, "use_temperature", False):
        color = [a * b for a, b in zip(color, rgb(light.temperature_color))]
    factor *= 2.0 ** getattr(light, "exposure", 0.0)
    if light.use_nodes and light.node_tree is not None:
        emission = surface_node(light.node_tree, "OUTPUT_LIGHT")
        tint = constant(emission.inputs["Color"]) if emission and emission.type == "EMISSION" else None
        strength = constant(emission.inputs["Strength"]) if tint is not None else None
        if strength is None:
            report.note(f"The nodes of the light “{light.name}” are ignored: only constant emission is read")
        else:
            color = [a * b for a, b in zip(color, rgb(tint))]
            factor *= max(strength, 0.0)
    return color, factor


def lights(depsgraph, report):
    """`[[light]]` and `[[object]]` entries, in the order of the dependency graph.

    Power becomes radiometric values as in Cycles: a point or spot light of P watts has the radiant intensity
    P / 4π, its sphere of radius r the radiance P / (4π² r²); an area light of area A has the radiance P / πA.
    """
    sections = []
    for instance in depsgraph.object_instances:
        source = instance.object
        if source.type != "LIGHT" or not instance.show_self:
            continue
        light = source.data
        color, factor = light_color(light, report)
        if light.energy * factor <= 0.0 or max(color) <= 0.0:
            continue
        matrix = instance.matrix_world.copy()
        one = {"SUN": sun, "AREA": area_light, "SPOT": spot_light}.get(light.type, point_light)
        sections.append(one(source, matrix, color, light.energy * factor, report))
    return sections


def direction_of(matrix):
    return (matrix.to_3x3() @ Vector((0, 0, -1))).normalized()


def sun(source, matrix, color, energy, report):
    return "[[light]]", {
        "type": "directional",
        "name": source.name,
        "direction": vector(direction_of(matrix)),
        "color": color,
        "intensity": energy,
        "angle": min(math.degrees(source.data.angle), 180.0),
    }


def emitter(source, shape, color, radiance):
    material = {
        "type": "principled",
        "base_color": 0.0,
        "specular_weight": 0.0,
        "emission_color": color,
        "emission_luminance": radiance,
        "emission_front_only": True,
        "double_sided": False,
    }
    # Cycles hides lights from the camera alone unless told otherwise.
    seen = {} if source.visible_camera else {"hidden_from_camera": True}
    return "[[object]]", {**shape, "name": source.name, **seen, "material": material}


def point_light(source, matrix, color, power, report):
    light = source.data
    radius = light.shadow_soft_size
    normalized = getattr(light, "normalize", True)
    position = vector(matrix.translation)
    intensity = power / (4.0 * math.pi)
    area = math.pi * radius * radius
    if not normalized:
        intensity *= area
    if radius <= 0.0:
        return "[[light]]", {
            "type": "point",
            "name": source.name,
            "position": position,
            "color": color,
            "intensity": intensity,
            "attenuation": "inverse-square",
        }
    shape = {"type": "sphere", "center": position, "radius": radius}
    return emitter(source, shape, color, intensity / area)


def spot_light(source, matrix, color, power, report):
    light = source.data
    intensity = power / (4.0 * math.pi)
    if not getattr(light, "normalize", True):
        intensity *= math.pi * light.shadow_soft_size**2
    half = min(0.5 * light.spot_size, 0.5 * math.pi)
    # Cycles' smooth step goes from the cosine of the edge to this one.
    full = math.acos(min(math.cos(half) + (1.0 - math.cos(half)) * light.spot_blend, 1.0))
    position = matrix.translation
    reach = 1.0 + max(abs(c) for c in position)
    return "[[light]]", {
        "type": "spot",
        "name": source.name,
        "position": vector(position),
        "look_at": vector(position + direction_of(matrix) * reach),
        "angle": math.degrees(half),
        "penumbra": math.degrees(half - full),
        "color": color,
        "intensity": intensity,
        "radius": light.shadow_soft_size,
        "attenuation": "inverse-square",
    }


def area_light(source, matrix, color, power, report):
    light = source.data
    if light.spread < math.pi - 1e-3:
        report.note("The spread of area lights is ignored: they emit in all directions")
    both = light.shape in {"RECTANGLE", "ELLIPSE"}
    size_u, size_v = light.size, light.size_y if both else light.size
    edge_u = matrix.to_3x3() @ Vector((size_u, 0, 0))
    edge_v = matrix.to_3x3() @ Vector((0, size_v, 0))
    area = edge_u.cross(edge_v).length
    if light.shape in {"DISK", "ELLIPSE"}:
        area *= 0.25 * math.pi
        # A disk of radius 1 with the normal +z; the light emits along -z.
        frame = Matrix.Identity(4)
        columns = (0.5 * edge_u, -0.5 * edge_v, direction_of(matrix), matrix.translation)
        for i, column in enumerate(columns):
            for row, value in enumerate(vector(column)):
                frame[row][i] = value
        shape = {"type": "disk", "normal": [0, 0, 1], "transform": {"matrix": [list(r) for r in frame[:3]]}}
    else:
        shape = {
            "type": "rectangle",
            "center": vector(matrix.translation),
            "edge_u": vector(edge_v),
            "edge_v": vector(edge_u),
        }
    if getattr(light, "normalize", True):
        radiance = power / (math.pi * area) if area > 0.0 else 0.0
    else:
        radiance = power / math.pi
    return emitter(source, shape, color, radiance)


# ---------------------------------------------------------------------------------------------------------------------
# World


def world_sections(scene, folder, report):
    """The background and the environment light."""
    background = {"transparent": True} if scene.render.film_transparent else {}
    world = scene.world
    if world is None:
        return [("[background]", background)] if background else []
    if not world.use_nodes or world.node_tree is None:
        return [("[background]", {**background, "color": rgb(world.color)})]
    if any(link.to_node.type == "OUTPUT_WORLD" and link.to_socket.name == "Volume" for link in world.node_tree.links):
        report.note("The volume of the world is ignored")
    node = surface_node(world.node_tree, "OUTPUT_WORLD")
    if node is None:
        return [("[background]", {**background, "color": 0.0})]
    strength = constant(node.inputs["Strength"]) if node.type == "BACKGROUND" else None
    if strength is None:
        report.note("The nodes of the world are not understood: only Background with a constant strength is read")
        return [("[background]", {**background, "color": rgb(world.color)})]
    color = constant(node.inputs["Color"])
    if color is not None:
        return [("[background]", {**background, "color": [max(strength, 0.0) * c for c in rgb(color)]})]
    source = linked_node(node.inputs["Color"])
    if source is not None and source.type == "TEX_SKY":
        light = sky(source, strength, report)
    else:
        light = environment(source, strength, folder, report)
    sections = [("[[light]]", light)] if light else []
    return sections + ([("[background]", background)] if background else [])


# The irradiance of a horizontal surface in Cycles divided by that in Turner, by the sun and by the sky: a mean of 17 skies.
SUN_SCALE = (38.7, 37.9, 34.6)
SKY_SCALE = (44.0, 38.5, 28.5)
# The same for its older models, which have no sun.
HOSEK_SCALE = (0.51, 0.62, 0.63)
PREETHAM_SCALE = (4.3, 4.6, 4.7)


def sky(node, strength, report):
    """A sky texture: Turner's sky with the composition of the air, brightness and sun of Cycles'."""
    strength = max(strength, 0.0)
    section = {"type": "sky"}
    # The models with a sun have no coordinates.
    turn = world_rotation(node, report) if "Vector" in node.inputs else 0.0
    if node.sky_type in {"PREETHAM", "HOSEK_WILKIE"}:
        scale = PREETHAM_SCALE if node.sky_type == "PREETHAM" else HOSEK_SCALE
        x, y, z = node.sun_direction
        return {
            **section,
            "elevation": math.degrees(math.atan2(z, math.hypot(x, y))),
            "azimuth": math.degrees(math.atan2(x, y)) - turn,
            "dust": max(node.turbidity - 1.0, 0.0) / 2.0,
            "ground_albedo": clamp01(node.ground_albedo),
            "sun": False,
            "sky_strength": [strength * c for c in scale],
        }
    # Blender 5 calls dust aerosol. Both thin out with altitude, in metres.
    dust = node.dust_density if hasattr(node, "dust_density") else node.aerosol_density
    section |= {
        "elevation": math.degrees(node.sun_elevation),
        "azimuth": math.degrees(node.sun_rotation) - turn,
        "air": node.air_density * math.exp(-node.altitude / 8000.0),
        # Turner's dust scatters three times as much.
        "dust": dust / 3.0 * math.exp(-node.altitude / 1200.0),
        "ozone": node.ozone_density,
        # About as dark as the sky that Cycles lets fade below the horizon.
        "ground_albedo": 0.04,
        "sun": node.sun_disc,
        "sky_strength": [strength * c for c in SKY_SCALE],
    }
    if node.sun_disc:
        section["sun_angle"] = math.degrees(node.sun_size)
        section["sun_strength"] = [strength * node.sun_intensity * c for c in SUN_SCALE]
    return section


def environment(node, strength, folder, report):
    if node is None or node.type != "TEX_ENVIRONMENT":
        report.note("The colour of the world is neither constant nor an environment or sky texture: the world is black")
        return None
    if node.projection != "EQUIRECTANGULAR":
        report.note("Mirror ball environments are read as equirectangular ones")
    name = folder.image(node.image)
    if name is None:
        return None
    return {
        "type": "environment",
        "file": name,
        "strength": max(strength, 0.0),
        # The centre of the picture lies along +x in Blender, along -z in Turner.
        "rotation": -90.0 + world_rotation(node, report),
    }


def world_rotation(node, report):
    """The rotation of an environment picture about the vertical axis, degrees."""
    mapping = linked_node(node.inputs["Vector"])
    if mapping is None or mapping.type != "MAPPING":
        return 0.0
    rotation = constant(mapping.inputs["Rotation"])
    if rotation is None or max(abs(rotation[0]), abs(rotation[1])) > 1e-4:
        report.note("An environment is rotated about the vertical axis only")
    angle = math.degrees(rotation[2]) if rotation is not None else 0.0
    return angle if mapping.vector_type == "TEXTURE" else -angle


# ---------------------------------------------------------------------------------------------------------------------
# Nodes


def linked_node(socket):
    """The node that a socket is linked to, past reroutes."""
    for _ in range(64):
        if not socket.is_linked:
            return None
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return node
        socket = node.inputs[0]
    return None


def surface_node(tree, output_type):
    """The node at the surface of the active output."""
    outputs = [n for n in tree.nodes if n.type == output_type]
    output = next((n for n in outputs if n.is_active_output), outputs[0] if outputs else None)
    return linked_node(output.inputs["Surface"]) if output else None


def constant(socket):
    """The value of a socket that no texture drives: a number, or a tuple. `None` otherwise."""
    if not socket.is_linked:
        value = getattr(socket, "default_value", None)
        return value if value is None or isinstance(value, (int, float)) else tuple(value)
    node = linked_node(socket)
    if node is not None and node.type in {"VALUE", "RGB"}:
        return constant_output(node)
    return None


def constant_output(node):
    value = node.outputs[0].default_value
    return value if isinstance(value, (int, float)) else tuple(value)


# ---------------------------------------------------------------------------------------------------------------------
# Materials


def materials(depsgraph, folder, report):
    """Replacements for the materials of the glTF file, by name.

    glTF's exporter reads Principled BSDF alone, and drops what glTF lacks: subsurface scattering, solid glass, thin
    films. So materials without textures are written in Turner's own keys; textured ones are left to glTF.
    """
    result = {}
    for material in bpy.data.materials:
        if material.is_grease_pencil or material.users == 0:
            continue
        value = material_of(material, folder, report)
        if value is not None:
            result[material.name] = value
    return result


def material_of(material, folder, report):
    if not material.use_nodes or material.node_tree is None:
        return {"type": "matte", "color": rgb(material.diffuse_color)}
    outputs = [n for n in material.node_tree.nodes if n.type == "OUTPUT_MATERIAL" and n.is_active_output]
    if outputs and outputs[0].inputs["Displacement"].is_linked:
        report.note("Displacement of materials is ignored")
    node = surface_node(material.node_tree, "OUTPUT_MATERIAL")
    volume = linked_node(outputs[0].inputs["Volume"]) if outputs else None
    if node is None:
        value = None if volume is None else {"type": "interface"}
        if volume is None:
            report.note(f"The material “{material.name}” has no surface")
    else:
        value = surface(node, folder, 0)
    if value is None and node is not None and node.type != "BSDF_PRINCIPLED":
        report.note(f"The nodes of the material “{material.name}” are left to glTF's exporter")
    if value is not None and volume is not None:
        medium = interior(volume)
        if medium is None or value["type"] not in {"principled", "interface"}:
            report.note(f"The volume of the material “{material.name}” is ignored")
        else:
            value["interior"] = medium
    return value


def interior(node):
    """A homogeneous medium, with Cycles' meaning of colour and density."""
    if node.type not in {"VOLUME_ABSORPTION", "VOLUME_SCATTER"}:
        return None
    color, density = constant(node.inputs["Color"]), constant(node.inputs["Density"])
    if color is None or density is None:
        return None
    color = [min(c, 1.0) for c in rgb(color)]
    if node.type == "VOLUME_ABSORPTION":
        return {"absorption": [density * (1.0 - c) for c in color], "scattering": 0.0}
    scattering = [density * c for c in color]
    if getattr(node, "phase", None) == "RAYLEIGH":
        return {"absorption": 0.0, "scattering": scattering, "rayleigh": 1.0}
    g = constant(node.inputs["Anisotropy"]) or 0.0
    return {"absorption": 0.0, "scattering": scattering, "anisotropy": min(max(g, -0.99), 0.99)}


def surface(node, folder, depth):
    """A material of Turner's scene format; `None` if this node is not understood."""
    if node is None or depth > 16:
        return None
    if node.type == "MIX_SHADER":
        weight = constant(node.inputs[0])
        parts = [surface(linked_node(node.inputs[i]), folder, depth + 1) for i in (1, 2)]
        if weight is None or None in parts:
            return None
        weight = min(max(float(weight), 0.0), 1.0)
        return {"type": "mix", "materials": parts, "weights": [1.0 - weight, weight]}
    if node.type == "BSDF_PRINCIPLED":
        return principled(node)
    if any(s.is_linked for s in node.inputs if s.name == "Normal"):
        return None
    simple = SIMPLE.get(node.type)
    return simple(node, folder) if simple else None


def color_or_image(socket, folder):
    """A constant colour, or an image that lies on the first texture coordinates."""
    value = constant(socket)
    if value is not None:
        return rgb(value)
    node = linked_node(socket)
    if node is None or node.type != "TEX_IMAGE" or node.inputs["Vector"].is_linked:
        return None
    name = folder.image(node.image)
    wrap = {"REPEAT": "repeat", "EXTEND": "clamp", "CLIP": "black", "MIRROR": "mirror"}[node.extension]
    return {"type": "image", "file": name, "wrap": wrap} if name else None


def numbers(node, *names):
    """Constant values of inputs; `None` if any is linked to a texture."""
    values = [constant(node.inputs[name]) for name in names]
    return None if None in values else values


def diffuse(node, folder):
    color, roughness = color_or_image(node.inputs["Color"], folder), constant(node.inputs["Roughness"])
    if color is None or roughness is None:
        return None
    return {"type": "matte", "color": color, "roughness": roughness}


def glossy(node, folder):
    color, roughness = color_or_image(node.inputs["Color"], folder), constant(node.inputs["Roughness"])
    if color is None or roughness is None:
        return None
    return {
        "type": "principled",
        "base_metalness": 1.0,
        "base_color": color,
        # Cycles' colour is the reflectance at all angles.
        "specular_color": color,
        "specular_roughness": roughness,
    }


def glass(node, folder):
    values = numbers(node, "Color", "Roughness", "IOR")
    if values is None:
        return None
    color, roughness, ior = values
    return {
        "type": "principled",
        "transmission_weight": 1.0,
        "transmission_color": rgb(color),
        "specular_roughness": roughness,
        "specular_ior": ior,
    }


def transparent(node, folder):
    color = constant(node.inputs["Color"])
    if color is None:
        return None
    return {
        "type": "principled",
        "transmission_weight": 1.0,
        "transmission_color": rgb(color),
        "specular_ior": 1.0,
        "specular_weight": 0.0,
        "specular_roughness": 0.0,
        "thin_walled": True,
    }


def emission(node, folder):
    color, strength = color_or_image(node.inputs["Color"], folder), constant(node.inputs["Strength"])
    if color is None or strength is None:
        return None
    return {"type": "emissive", "color": color, "strength": max(strength, 0.0)}


SIMPLE = {
    "BSDF_DIFFUSE": diffuse,
    "BSDF_GLOSSY": glossy,
    "BSDF_ANISOTROPIC": glossy,
    "BSDF_GLASS": glass,
    "BSDF_TRANSPARENT": transparent,
    "EMISSION": emission,
}


def principled(node):
    """Principled BSDF without textures in OpenPBR's parameters; `None` if a texture drives any of them."""
    value = {}
    for socket in node.inputs:
        if socket.name in {"Normal", "Coat Normal", "Tangent"}:
            if socket.is_linked:
                return None
            continue
        value[socket.name] = constant(socket)
        if value[socket.name] is None and socket.is_linked:
            return None
    base = rgb(value["Base Color"])
    ior, level = max(value["IOR"], 1e-3), value["Specular IOR Level"]
    metallic, transmission = clamp01(value["Metallic"]), clamp01(value["Transmission Weight"])
    roughness, anisotropy = anisotropic(clamp01(value["Roughness"]), clamp01(value["Anisotropic"]))
    result = {
        "type": "principled",
        "base_color": base,
        "base_metalness": metallic,
        "base_diffuse_roughness": clamp01(value.get("Diffuse Roughness") or 0.0),
        "specular_ior": scaled_ior(ior, 2.0 * level),
        "specular_roughness": roughness,
    }
    tint = rgb(value["Specular Tint"])
    result["specular_color"] = tint
    if metallic == 0.0:
        # Cycles' tint is a factor of the reflectance at normal incidence, as in glTF.
        result["specular_model"] = "gltf"
    if anisotropy > 0.0:
        result["specular_roughness_anisotropy"] = anisotropy
        result["anisotropy_rotation"] = 360.0 * value["Anisotropic Rotation"]
    if transmission > 0.0:
        # Light that crosses the body twice has the base colour.
        result["transmission_weight"] = transmission
        result["transmission_color"] = [math.sqrt(min(c, 1.0)) for c in base]
    principled_layers(value, base, result)
    return result


def principled_layers(value, base, result):
    """Subsurface scattering, coat, sheen, thin film, emission and alpha."""
    subsurface = clamp01(value["Subsurface Weight"])
    if subsurface > 0.0 and value["Subsurface Scale"] > 0.0:
        result["subsurface_weight"] = subsurface
        result["subsurface_color"] = [min(c, 1.0) for c in base]
        result["subsurface_radius"] = value["Subsurface Scale"]
        factors = [mean_free_path(min(c, 1.0), max(value["IOR"], 1.01)) for c in base]
        result["subsurface_radius_scale"] = [r * f for r, f in zip(rgb(value["Subsurface Radius"]), factors)]
        result["subsurface_scatter_anisotropy"] = min(max(value["Subsurface Anisotropy"], -0.99), 0.99)
    if value["Coat Weight"] > 0.0:
        result["coat_weight"] = clamp01(value["Coat Weight"])
        result["coat_roughness"] = clamp01(value["Coat Roughness"])
        result["coat_ior"] = max(value["Coat IOR"], 1.0)
        result["coat_color"] = rgb(value["Coat Tint"])
        result["coat_darkening"] = 0.0
    if value["Sheen Weight"] > 0.0:
        result["fuzz_weight"] = clamp01(value["Sheen Weight"])
        result["fuzz_roughness"] = clamp01(value["Sheen Roughness"])
        result["fuzz_color"] = rgb(value["Sheen Tint"])
    if (value.get("Thin Film Thickness") or 0.0) > 0.0:
        result["thin_film_weight"] = 1.0
        # Nanometres to micrometres.
        result["thin_film_thickness"] = value["Thin Film Thickness"] * 1e-3
        result["thin_film_ior"] = value["Thin Film IOR"]
    if value["Emission Strength"] > 0.0:
        result["emission_luminance"] = value["Emission Strength"]
        result["emission_color"] = rgb(value["Emission Color"])
    if value["Alpha"] < 1.0:
        result["opacity"] = clamp01(value["Alpha"])
        result["alpha_mode"] = "blend"


def mean_free_path(albedo, ior):
    """The mean free path of light inside as a fraction of Cycles' radius, which is a diffusion length.

    It is √(3 (1 - α)), where α is the single-scattering albedo of the dipole whose diffuse reflectance is `albedo`
    (Jensen et al. 2001, A Practical Model for Subsurface Light Transport, equation 15).
    """
    reflected = -1.44 / (ior * ior) + 0.71 / ior + 0.668 + 0.0636 * ior
    a = 4.0 / 3.0 * (1.0 + reflected) / (1.0 - reflected)
    low, high = 0.0, 1.0
    for _ in range(40):
        alpha = 0.5 * (low + high)
        root = math.sqrt(3.0 * (1.0 - alpha))
        reflectance = 0.5 * alpha * (1.0 + math.exp(-a * root)) * math.exp(-root)
        low, high = (alpha, high) if reflectance < albedo else (low, alpha)
    return math.sqrt(3.0 * (1.0 - low))


def clamp01(x):
    return min(max(float(x), 0.0), 1.0)


def scaled_ior(ior, factor):
    """The index of refraction whose reflectance at normal incidence is `factor` times that of `ior`."""
    if factor == 1.0:
        return ior
    f0 = min(factor * ((ior - 1.0) / (ior + 1.0)) ** 2, 0.99)
    root = math.sqrt(max(f0, 0.0))
    return (1.0 + root) / (1.0 - root)


def anisotropic(roughness, amount):
    """Cycles has α = r²·a and r²/a with a² = 1 - 0.9·amount; OpenPBR has α and (1 - b)·α with α²(1 + (1 - b)²) = 2r⁴."""
    if amount == 0.0:
        return roughness, 0.0
    ratio = 1.0 - 0.9 * amount
    return min(roughness * ((1.0 + ratio * ratio) / (2.0 * ratio)) ** 0.25, 1.0), 1.0 - ratio


# ---------------------------------------------------------------------------------------------------------------------
# glTF


class RenderModifiers:
    """Shows modifiers as they are rendered, since the exporter evaluates them as they are shown in the viewport.

    The exporter evaluates shape keys only of objects with modifiers: others get one that triangulates, as it does.
    """

    def __init__(self, sources):
        self.sources = sources
        self.changed = []
        self.added = []

    def __enter__(self):
        for source in self.sources:
            if source.type == "MESH" and source.data.shape_keys and not source.modifiers and source.is_editable:
                self.added.append((source, source.modifiers.new("Turner", "TRIANGULATE")))
            for modifier in source.modifiers:
                self._set(modifier, "show_viewport", modifier.show_render)
                if modifier.type in {"SUBSURF", "MULTIRES"}:
                    self._set(modifier, "levels", modifier.render_levels)
        return self

    def _set(self, modifier, key, value):
        old = getattr(modifier, key)
        if old != value:
            self.changed.append((modifier, key, old))
            setattr(modifier, key, value)

    def __exit__(self, *_):
        for modifier, key, old in reversed(self.changed):
            setattr(modifier, key, old)
        for source, modifier in self.added:
            source.modifiers.remove(modifier)


def export_gltf(scene, sources, path):
    """Writes the objects of the scene at its current frame; `sources` are the objects that are rendered."""
    options = {
        "filepath": str(path),
        "check_existing": False,
        "export_format": "GLB",
        "export_image_format": "AUTO",
        "use_active_scene": True,
        "use_renderable": True,
        "export_apply": True,
        "export_yup": True,
        "export_cameras": False,
        "export_lights": False,
        "export_animations": False,
        "export_current_frame": True,
        "export_skins": False,
        "export_morph": False,
        "export_extras": False,
        "export_gn_mesh": True,
        "will_save_settings": False,
    }
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    options = {key: value for key, value in options.items() if key in known}
    windows = bpy.context.window_manager.windows if bpy.context.window_manager else []
    window = next((w for w in windows if w.scene == scene), None)
    context = {"window": window} if window else {"scene": scene, "view_layer": scene.view_layers[0]}
    with RenderModifiers(sources), bpy.context.temp_override(**context):
        bpy.ops.export_scene.gltf(**options)


def mend_glb(path, visible):
    """Changes a GLB file where glTF means something else than Blender.

    - Blender's surfaces have two sides.
    - Transmissive surfaces bound a body: without a thickness, glTF's are thin walls.
    - Faces without a material are white plaster; glTF's would be rough metal.
    - Objects in collections that are not rendered have no mesh. `visible` has the names of those that are.
    """
    data = Path(path).read_bytes()
    magic, _, _, length, kind = struct.unpack_from("<5I", data)
    if magic != 0x46546C67 or kind != 0x4E4F534A:
        raise ValueError("the exporter wrote no GLB file")
    document = json.loads(data[20 : 20 + length])
    extensions = set(document.get("extensionsUsed", []))
    for material in document.get("materials", []):
        material["doubleSided"] = True
        used = material.get("extensions", {})
        if "KHR_materials_transmission" in used:
            used.setdefault("KHR_materials_volume", {}).setdefault("thicknessFactor", 1.0)
            extensions.add("KHR_materials_volume")
    for node in document.get("nodes", []):
        name = node.get("name")
        if "mesh" in node and name in bpy.data.objects and name not in visible:
            del node["mesh"]
    bare = [p for m in document.get("meshes", []) for p in m["primitives"] if "material" not in p]
    if bare:
        plaster = {
            "name": "no material",
            "doubleSided": True,
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.8, 0.8, 0.8, 1],
                "metallicFactor": 0,
                "roughnessFactor": 1,
            },
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
        }
        extensions.add("KHR_materials_specular")
        document.setdefault("materials", []).append(plaster)
        for primitive in bare:
            primitive["material"] = len(document["materials"]) - 1
    if extensions:
        document["extensionsUsed"] = sorted(extensions)
    text = json.dumps(document, ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    header = struct.pack("<5I", magic, 2, 20 + len(text) + len(rest), len(text), kind)
    Path(path).write_bytes(header + text + rest)
    return bool(document.get("meshes"))


# ---------------------------------------------------------------------------------------------------------------------
# The scene


def picture_size(scene):
    """Width and height of the full frame, and the border as (x, y, width, height) from the top left, or `None`."""
    render = scene.render
    scale = render.resolution_percentage / 100.0
    width, height = max(int(render.resolution_x * scale), 1), max(int(render.resolution_y * scale), 1)
    if not render.use_border:
        return width, height, None
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    if right <= left or top <= bottom:
        return width, height, None
    return width, height, (left, height - top, right - left, top - bottom)


def aovs(view_layer):
    """Turner's channels for the passes of a view layer."""
    names = []
    if view_layer.use_pass_z:
        names.append("depth")
    if view_layer.use_pass_normal:
        names.append("normal")
    if view_layer.use_pass_diffuse_color:
        names.append("albedo")
    return names


def film_section(scene, view_layer):
    settings = scene.turner
    width, height, border = picture_size(scene)
    film = {
        "width": width,
        "height": height,
        "antialias": "monte-carlo",
        "samples": settings.samples,
        "denoise": settings.denoise,
        "seed": settings.seed,
        "fireflies": "remove" if settings.remove_fireflies else "keep",
        "aovs": aovs(view_layer),
        "exposure": scene.view_settings.exposure,
    }
    if border:
        film["crop"] = list(border)
    return "[film]", film


def write_scene(depsgraph, camera, path, report):
    """Writes `scene.toml` and `scene.glb` to a folder."""
    scene, view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    folder = Folder(path, report)
    # The iterator reuses its instances, and a name may stand for several objects of linked files.
    visible = {i.object.original for i in depsgraph.object_instances if i.show_self}
    width, height, _ = picture_size(scene)
    sections = [
        film_section(scene, view_layer),
        ("[integrator]", {"type": "path", "max_depth": scene.turner.max_depth}),
        ("[camera]", camera_section(depsgraph, camera, width, height, report)),
        *world_sections(scene, folder, report),
        *lights(depsgraph, report),
    ]
    if scene.render.use_motion_blur:
        report.note("Motion blur is ignored")
    for source in visible:
        if source.type != "LIGHT" and not source.visible_camera:
            report.note(f"“{source.name}” is hidden from the camera in Blender, and visible to it in Turner")
    glb = folder.path / "scene.glb"
    export_gltf(scene.original, visible, glb)
    if mend_glb(glb, {source.name for source in visible}):
        replaced = materials(depsgraph, folder, report)
        model = {"type": "model", "name": "blender", "file": glb.name}
        sections.append(("[[object]]", model | ({"materials": replaced} if replaced else {})))
    text = "\n".join(toml_section(header, values) for header, values in sections)
    target = folder.path / "scene.toml"
    target.write_text(text, encoding="utf-8")
    return target


# ---------------------------------------------------------------------------------------------------------------------
# The picture


def read_exr(path):
    """The channels of an uncompressed scan line OpenEXR file, by name, with rows from bottom to top."""
    data = Path(path).read_bytes()
    if data[:4] != b"\x76\x2f\x31\x01":
        raise ValueError(f"{path} is no OpenEXR file")
    header, at = exr_header(data)
    if header["compression"][0] != 0:
        raise ValueError(f"{path} is compressed")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = exr_channels(header["channels"])
    size = sum(width * np.dtype(kind).itemsize for _, kind in channels)
    # A table with the offset of each row; each row begins with its y and its size.
    offsets = np.frombuffer(data, "<u8", height, at)
    result = {name: np.empty((height, width), np.float32) for name, _ in channels}
    for offset in offsets.tolist():
        y, row = struct.unpack_from("<2i", data, offset)
        if row != size:
            raise ValueError(f"{path}: a row of {row} bytes instead of {size}")
        offset += 8
        for name, kind in channels:
            result[name][height - 1 - (y - y0)] = np.frombuffer(data, kind, width, offset)
            offset += width * np.dtype(kind).itemsize
    return result


def exr_header(data):
    """Attributes by name, and the position after them."""
    header, at = {}, 8
    while data[at] != 0:
        name_end = data.index(0, at)
        type_end = data.index(0, name_end + 1)
        (size,) = struct.unpack_from("<i", data, type_end + 1)
        start = type_end + 5
        header[data[at:name_end].decode()] = data[start : start + size]
        at = start + size
    return header, at + 1


def exr_channels(data):
    channels, at = [], 0
    while data[at] != 0:
        end = data.index(0, at)
        (kind,) = struct.unpack_from("<i", data, end + 1)
        channels.append((data[at:end].decode(), ("<u4", "<f2", "<f4")[kind]))
        at = end + 17
    return channels


def passes(channels):
    """Blender's passes as arrays of height x width x components."""
    alpha = channels.get("A", np.ones_like(channels["R"]))
    result = {"Combined": np.dstack([channels["R"], channels["G"], channels["B"], alpha])}
    if "Z" in channels:
        result["Depth"] = channels["Z"][..., None]
    if "N.X" in channels:
        # Back to Blender's axes.
        result["Normal"] = np.dstack([channels["N.X"], -channels["N.Z"], channels["N.Y"]])
    if "albedo.R" in channels:
        names = ("albedo.R", "albedo.G", "albedo.B")
        # The pass was renamed in Blender 5.0.
        result["DiffCol"] = result["Diffuse Color"] = np.dstack([channels[n] for n in names])
    return result


# ---------------------------------------------------------------------------------------------------------------------
# The program


def preferences():
    addon = bpy.context.preferences.addons.get(__name__)
    return addon.preferences if addon else None


def find_turner():
    """The program: preferences, the environment variable TURNER, PATH, cargo's folder; `None` if it is nowhere."""
    chosen = preferences()
    if chosen and chosen.executable:
        path = bpy.path.abspath(chosen.executable)
        return path if os.access(path, os.X_OK) and os.path.isfile(path) else None
    if os.environ.get("TURNER"):
        return shutil.which(os.environ["TURNER"])
    return shutil.which("turner") or shutil.which("turner", path=str(Path.home() / ".cargo" / "bin"))


def arguments(program, scene_file, picture, settings):
    result = [program, "render", str(scene_file), "-o", str(picture), "--json", "--exr-compression", "none"]
    result += ["--bit-depth", "32"]
    if settings.seconds > 0.0:
        result += ["--budget", f"{settings.seconds:g}s"]
    if settings.threads > 0:
        result += ["--threads", str(settings.threads)]
    return result


class Process:
    """Turner as a child process, with its events."""

    def __init__(self, command):
        flags = getattr(subprocess, "CREATE_NO_WINDOW", 0)
        self.done = 0.0
        self.errors = []
        self.warnings = []
        self.child = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            creationflags=flags,
        )
        self.readers = [threading.Thread(target=f, daemon=True) for f in (self._read, self._read_errors)]
        for reader in self.readers:
            reader.start()

    def _read(self):
        for line in self.child.stdout:
            try:
                event = json.loads(line)
            except ValueError:
                continue
            kind = event.get("event")
            if kind == "progress":
                self.done = float(event.get("done") or 0.0)
            elif kind == "warning" and event.get("kind") != "note":
                self.warnings.append(str(event.get("message")))
            elif kind == "error":
                remedy = event.get("help")
                self.errors.append(str(event.get("message")) + (f" ({remedy})" if remedy else ""))

    def _read_errors(self):
        for line in self.child.stderr:
            if line.strip() and len(self.errors) < 20:
                self.errors.append(line.strip())

    def finished(self, seconds):
        try:
            self.child.wait(seconds)
        except subprocess.TimeoutExpired:
            return False
        for reader in self.readers:
            reader.join(5.0)
        return True

    def cancel(self):
        """Turner writes the picture so far when it is asked to end."""
        self.child.terminate()
        if not self.finished(5.0):
            self.child.kill()
            self.child.wait()


def in_main_thread(function):
    """Runs a function in Blender's main thread, which alone may change data while the interface is in use."""
    if bpy.app.background or threading.current_thread() is threading.main_thread():
        return function()
    begun, done, result = threading.Event(), threading.Event(), {}

    def task():
        if begun.is_set():
            return None
        begun.set()
        try:
            result["value"] = function()
        except BaseException as error:
            result["error"] = error
        done.set()
        return None

    bpy.app.timers.register(task)
    if not begun.wait(10.0) and not begun.is_set():
        # The main thread waits for this render, as in `bpy.ops.render.render()` of a script.
        begun.set()
        bpy.app.timers.unregister(task)
        return function()
    done.wait()
    if "error" in result:
        raise result["error"]
    return result["value"]


class TurnerRenderEngine(bpy.types.RenderEngine):
    bl_idname = "TURNER"
    bl_label = "Turner"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        if renderlayer.use_pass_z:
            self.register_pass(scene, renderlayer, "Depth", 1, "Z", "VALUE")
        if renderlayer.use_pass_normal:
            self.register_pass(scene, renderlayer, "Normal", 3, "XYZ", "VECTOR")
        if renderlayer.use_pass_diffuse_color:
            name = "DiffCol" if bpy.app.version < (5, 0, 0) else "Diffuse Color"
            self.register_pass(scene, renderlayer, name, 3, "RGB", "COLOR")

    def render(self, depsgraph):
        program = find_turner()
        if program is None:
            self.fail(depsgraph, MISSING)
            return
        scene = depsgraph.scene
        camera = self.camera_override or scene.camera
        if camera is None:
            self.fail(depsgraph, "The scene has no camera")
            return
        folder = tempfile.mkdtemp(prefix="turner-")
        try:
            self._render(depsgraph, camera.evaluated_get(depsgraph), program, Path(folder))
        except (OSError, ValueError, RuntimeError) as error:
            self.fail(depsgraph, f"Turner: {error}")
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _render(self, depsgraph, camera, program, folder):
        report = Report()
        self.update_stats("", "Turner: exporting")
        scene_file = in_main_thread(lambda: write_scene(depsgraph, camera, folder, report))
        picture = folder / "picture.exr"
        process = Process(arguments(program, scene_file, picture, depsgraph.scene.turner))
        while not process.finished(0.1):
            self.update_progress(process.done)
            self.update_stats("", f"Turner: {100.0 * process.done:.0f} %")
            if self.test_break():
                process.cancel()
        for line in report.lines + process.warnings:
            self.report({"WARNING"}, line)
        if not picture.is_file():
            if not self.test_break():
                reason = "; ".join(process.errors) or f"it ended with code {process.child.returncode}"
                self.fail(depsgraph, f"Turner wrote no picture: {reason}")
            return
        self.show(depsgraph, passes(read_exr(picture)))

    def fail(self, depsgraph, message):
        """Shows a message above an empty picture: without a picture, Blender 4.5 crashes where it saves one."""
        width, height, border = picture_size(depsgraph.scene)
        width, height = border[2:] if border else (width, height)
        self.end_result(self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name))
        self.error_set(message)
        self.report({"ERROR"}, message)

    def show(self, depsgraph, arrays):
        height, width = arrays["Combined"].shape[:2]
        result = self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name)
        for render_pass in result.layers[0].passes:
            array = arrays.get(render_pass.name)
            if array is not None:
                pixels = np.ascontiguousarray(array, np.float32).ravel()
                render_pass.rect.foreach_set(pixels)
        self.end_result(result)


# ---------------------------------------------------------------------------------------------------------------------
# Interface


class TurnerPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__

    executable: StringProperty(
        name="Program", description="Path of the program turner; empty: search the PATH", subtype="FILE_PATH"
    )

    def draw(self, context):
        self.layout.prop(self, "executable")
        if find_turner() is None:
            self.layout.label(text="The program turner was not found", icon="ERROR")


class TurnerSettings(bpy.types.PropertyGroup):
    samples: IntProperty(name="Samples", description="Samples per pixel", default=64, min=1, max=16777216)
    denoise: EnumProperty(
        name="Denoise",
        description="Remove the noise of the finished picture",
        items=(
            ("on", "Turner", "Turner's denoiser"),
            ("fast", "Fast", "One fit per block: faster, less exact"),
            ("off", "Off", "Keep the noise"),
        ),
        default="on",
    )
    seed: IntProperty(name="Seed", description="Seed of the random numbers", default=0, min=0)
    max_depth: IntProperty(
        name="Bounces", description="Maximum number of bounces of a path", default=16, min=0, max=1000
    )
    remove_fireflies: BoolProperty(
        name="Remove Fireflies",
        description="Scale samples down that are far brighter than all others near them",
        default=True,
    )
    seconds: FloatProperty(
        name="Time Limit", description="End after this many seconds; 0: no limit", default=0.0, min=0.0
    )
    threads: IntProperty(name="Threads", description="Number of threads; 0: all cores", default=0, min=0, max=1024)


class TURNER_PT_render(bpy.types.Panel):
    bl_label = "Turner"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"TURNER"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for key in ("samples", "denoise", "remove_fireflies", "max_depth", "seed", "seconds", "threads"):
            layout.prop(context.scene.turner, key)
        layout.prop(context.scene.render, "film_transparent", text="Transparent")
        layout.operator("turner.export")


class TURNER_OT_export(bpy.types.Operator):
    """Write the scene as scene.toml and scene.glb, for the program turner or Turner Studio"""

    bl_idname = "turner.export"
    bl_label = "Export for Turner"

    directory: StringProperty(subtype="DIR_PATH")

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        depsgraph = context.evaluated_depsgraph_get()
        if context.scene.camera is None:
            self.report({"ERROR"}, "The scene has no camera")
            return {"CANCELLED"}
        report = Report()
        try:
            os.makedirs(self.directory, exist_ok=True)
            target = write_scene(depsgraph, context.scene.camera.evaluated_get(depsgraph), self.directory, report)
        except (OSError, ValueError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for line in report.lines:
            self.report({"WARNING"}, line)
        self.report({"INFO"}, f"Wrote {target}")
        return {"FINISHED"}


# Panels of EEVEE that show what Turner reads.
EEVEE_PANELS = {
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_NEXT_MATERIAL_PT_settings",
    "EEVEE_WORLD_PT_surface",
    "DATA_PT_EEVEE_light",
}
HIDDEN_PANELS = {"RENDER_PT_freestyle", "RENDER_PT_simplify", "VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes"}


def panels():
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines is None or panel.__name__ in HIDDEN_PANELS:
            continue
        if "BLENDER_RENDER" in engines or panel.__name__ in EEVEE_PANELS:
            yield panel


CLASSES = (TurnerPreferences, TurnerSettings, TurnerRenderEngine, TURNER_PT_render, TURNER_OT_export)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.turner = PointerProperty(type=TurnerSettings)
    for panel in panels():
        panel.COMPAT_ENGINES.add("TURNER")


def unregister():
    for panel in panels():
        panel.COMPAT_ENGINES.discard("TURNER")
    del bpy.types.Scene.turner
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


if __name__ == "__main__":
    register()
