#!/usr/bin/env python3
"""Renders one scene with another renderer, as often as requested. `turner-lab render --peers` and `turner-lab scenes`
run it.

    python render.py PEER SCENE THREADS        # PEER: mitsuba-llvm, mitsuba-llvm-independent, mitsuba-scalar, cycles

SCENE.json is a description as in scenes/peers (its format: scenes/peers/README.md). SCENE.xml is a scene of Mitsuba, for
Mitsuba alone, which keeps its integrator and its sampler: the size of its film is the first line of standard output,
{"width", "height"}, and the size to render the first one of standard input, `WIDTH HEIGHT`. Each further line of
standard input requests a picture: `SAMPLES SEED FILE`. FILE receives rows from the top, three little-endian 32-bit
floats per pixel. Standard output has one JSON object per line: {"start_seconds", "version"} after a first picture of one
sample, {"samples", "seconds", "width", "height"} for each picture, {"error", "help"} when something fails. start_seconds
is the time before the first picture, without that of the picture itself: modules, scene, BVHs, kernels. The kernels that
Mitsuba compiles later for other numbers of samples are not measured.
"""
import json
import math
import os
import sys
import time
from pathlib import Path

T0 = time.perf_counter()
# Modules print to standard output, also from below Python: that output goes to standard error.
OUT = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)


def say(**what):
    print(json.dumps(what), file=OUT, flush=True)


def lamp_axes(np, light):
    """Centre, edges and normal of a quad light; the edges are ordered so that their cross product is along the normal."""
    v = np.array(light["vertices"], float)
    u, w, n = v[1] - v[0], v[3] - v[0], np.array(light["emit_normal"], float)
    if np.dot(np.cross(u, w), n) < 0:
        u, w = w, u
    return v.mean(0), u, w, n


def sky(np, d, light):
    """Radiance from the directions d, of shape (..., 3), by the description's formula."""
    y = d[..., 1:2]
    t = np.sqrt(np.clip(y, 0, 1))
    above = np.array(light["horizon"]) * (1 - t) + np.array(light["zenith"]) * t
    glow = np.exp(light["kappa"] * (d @ np.array(light["sun_dir"]) - 1))[..., None]
    return np.where(y >= 0, above, np.array(light["ground"])) + np.array(light["sun"]) * glow


def sky_directions(np, height, of_angles):
    """Directions of the pixel centres: `of_angles` maps u and v, both from 0 to 1 and v from the top, to x, y, z."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(2 * height) + 0.5) / (2 * height), indexing="ij")
    return np.stack(of_angles(u, v), -1)


# ---------------------------------------------------------------- Mitsuba


class NoLlvm(Exception):
    pass


def find_llvm():
    """Tells Dr.Jit where libLLVM is, if it has one of the usual names: version 16 and newer. Dr.Jit refuses versions
    before 15, and 15 crashes with some of Mitsuba's kernels."""
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        return
    found = []
    for folder in ("/usr/lib", "/usr/lib64", "/usr/local/lib", "/opt/homebrew/opt"):
        for pattern in ("libLLVM*.so*", "*/libLLVM*.so*", "llvm*/lib/libLLVM*.so*", "llvm*/lib/libLLVM*.dylib"):
            for path in Path(folder).glob(pattern):
                digits = "".join(c if c.isdigit() else " " for c in path.name + " " + path.parts[-3]).split()
                version = int(digits[0]) if digits else 0
                if 16 <= version < 100:
                    found.append((version, str(path)))
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = max(found)[1]
    elif sys.platform == "linux":
        raise NoLlvm


class Mitsuba:
    def start(self, peer, threads):
        """Imports the modules of a variant."""
        if "llvm" in peer:
            find_llvm()
        import numpy as np
        import drjit as dr
        import mitsuba as mi

        self.np, self.mi = np, mi
        mi.set_variant("scalar_rgb" if "scalar" in peer else "llvm_ad_rgb")
        mi.set_log_level(mi.LogLevel.Error)
        dr.set_thread_count(threads)
        self.version = mi.__version__
        # The numbers of samples that kernels are compiled for.
        self.compiled = set() if "llvm" in peer else None

    def __init__(self, peer, scene, folder, threads):
        self.start(peer, threads)
        np, mi = self.np, self.mi
        self.folder = folder
        camera = scene["camera"]
        self.width, self.height = camera["res"]
        to_world = mi.ScalarTransform4f().look_at(origin=camera["origin"], target=camera["target"], up=camera["up"])
        film = {"type": "hdrfilm", "width": self.width, "height": self.height, "pixel_format": "rgb",
                "component_format": "float32", "filter": {"type": "box"}}
        # The stratified sampler has much less noise; the independent one is the default of Mitsuba's scenes.
        sampler = {"type": "independent" if peer.endswith("independent") else "multijitter"}
        parts = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": scene["max_depth"]},
            "camera": {"type": "perspective", "fov": camera["vfov_deg"], "fov_axis": "y", "near_clip": 1e-2, "far_clip": 1e5,
                       "to_world": to_world, "film": film, "sampler": sampler},
        }
        self.materials = {name: mi.load_dict(self.material(m)) for name, m in scene["materials"].items()}
        for i, shape in enumerate(scene["shapes"]):
            parts[f"shape{i}"] = self.shape(f"shape{i}", shape)
        for i, light in enumerate(scene["lights"]):
            parts[f"light{i}"] = self.light(light)
        self.scene = mi.load_dict(parts)

    @staticmethod
    def rgb(value):
        return {"type": "rgb", "value": value}

    def material(self, m):
        kind = m["type"]
        if kind == "dielectric":
            return {"type": "dielectric", "int_ior": m["int_ior"], "ext_ior": m["ext_ior"]}
        if kind == "diffuse":
            inner = {"type": "diffuse", "reflectance": self.rgb(m["reflectance"])}
        else:
            inner = {"type": "conductor", "material": "none", "specular_reflectance": self.rgb(m["reflectance"])}
            if kind == "ggx_conductor":
                inner.update(type="roughconductor", distribution="ggx", alpha=m["alpha"])
        return {"type": "twosided", "inner": inner}

    def shape(self, name, s):
        np, mi, material = self.np, self.mi, self.materials[s["material"]]
        if s["type"] == "sphere":
            return {"type": "sphere", "center": s["center"], "radius": s["radius"], "bsdf": material}
        if s["type"] == "ply":
            return {"type": "ply", "filename": str(self.folder / s["file"]), "face_normals": True, "bsdf": material}
        props = mi.Properties()
        props["face_normals"] = True
        props["bsdf"] = material
        mesh = mi.Mesh(name, len(s["vertices"]), len(s["faces"]), props=props)
        values = mi.traverse(mesh)
        values["vertex_positions"] = np.array(s["vertices"], np.float32).ravel()
        values["faces"] = np.array(s["faces"], np.uint32).ravel()
        values.update()
        return mesh

    def light(self, light):
        np, mi = self.np, self.mi
        if light["type"] == "analytic_env":
            def angles(u, v):
                theta, phi = math.pi * v, 2 * math.pi * u
                return np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)
            picture = sky(np, sky_directions(np, 1024, angles), light)
            return {"type": "envmap", "bitmap": mi.Bitmap(picture.astype(np.float32))}
        # Without a BSDF of its own a light is half grey.
        emissive = {"bsdf": {"type": "diffuse", "reflectance": self.rgb(0.0)},
                   "emitter": {"type": "area", "radiance": self.rgb(light["radiance"])}}
        if light["type"] == "sphere":
            return {"type": "sphere", "center": light["center"], "radius": light["radius"], **emissive}
        middle, u, w, n = lamp_axes(np, light)
        matrix = np.eye(4)
        matrix[:3] = np.stack([u / 2, w / 2, n, middle], 1)
        return {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix.tolist()), **emissive}

    def render(self, samples, seed):
        # Kernels are compiled again for each number of samples, which is not measured.
        if self.compiled is not None and samples not in self.compiled:
            self.compiled.add(samples)
            self.np.array(self.mi.render(self.scene, spp=samples, seed=seed))
        start = time.perf_counter()
        # The conversion to an array waits for the picture.
        picture = self.np.array(self.mi.render(self.scene, spp=samples, seed=seed), dtype="<f4")
        seconds = time.perf_counter() - start
        # A film of luminance has one channel.
        picture = picture[..., :3] if picture.shape[-1] >= 3 else self.np.repeat(picture[..., :1], 3, -1)
        # Stratified samplers round the number of samples up.
        return picture, seconds, self.scene.sensors()[0].sampler().sample_count()


class MitsubaFile(Mitsuba):
    """A scene in Mitsuba's own format, in another size."""

    def __init__(self, peer, path, threads):
        self.start(peer, threads)
        self.scene = self.mi.load_file(str(path))
        if not self.scene.sensors():
            raise ValueError("the scene has no sensor")
        # Pictures are rendered from the first one.
        sensor = self.scene.sensors()[0]
        film = sensor.film()
        if list(film.crop_size()) != list(film.size()):
            raise ValueError("the film has a crop window, which does not scale")
        self.width, self.height = (int(v) for v in film.size())
        say(width=self.width, height=self.height)
        self.width, self.height = (int(v) for v in sys.stdin.readline().split())
        values = self.mi.traverse(sensor)
        values["film.size"] = [self.width, self.height]
        values.update()


# ---------------------------------------------------------------- Cycles


class Cycles:
    def __init__(self, scene, folder, threads):
        import numpy as np
        import bpy
        import mathutils
        import tempfile

        self.np, self.bpy, self.matrix = np, bpy, mathutils.Matrix
        self.version = bpy.app.version_string
        self.temporary = tempfile.TemporaryDirectory()
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.context = bpy.context.scene
        self.materials = {name: self.material(name, m) for name, m in scene["materials"].items()}
        self.black = self.material("black", {"type": "diffuse", "reflectance": [0, 0, 0]})
        for i, s in enumerate(scene["shapes"]):
            if s["type"] == "sphere":
                points, faces = self.sphere(s["center"], s["radius"], 256)
            elif s["type"] == "ply":
                points, faces = self.ply(folder / s["file"])
            else:
                points, faces = np.array(s["vertices"], float), np.array(s["faces"])
            self.mesh(f"shape{i}", points, faces, self.materials[s["material"]], s["type"] == "sphere")
        for i, light in enumerate(scene["lights"]):
            self.light(f"light{i}", light)
        self.camera(scene["camera"])
        self.settings(scene, threads)

    @staticmethod
    def turned(np, p):
        """From the description's axes (y up) to Blender's (z up)."""
        p = np.asarray(p, float)
        return np.stack([p[..., 0], -p[..., 2], p[..., 1]], -1)

    def material(self, name, m):
        material = self.bpy.data.materials.new(name)
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        names = {"diffuse": "ShaderNodeBsdfDiffuse", "dielectric": "ShaderNodeBsdfGlass"}
        node = tree.nodes.new(names.get(m["type"], "ShaderNodeBsdfAnisotropic"))
        node.inputs["Color"].default_value = (*m.get("reflectance", (1, 1, 1)), 1)
        # Cycles squares its roughness, as Turner does.
        node.inputs["Roughness"].default_value = math.sqrt(m.get("alpha", 0))
        if m["type"] != "diffuse":
            node.distribution = "GGX"
        if m["type"] == "dielectric":
            node.inputs["IOR"].default_value = m["int_ior"] / m["ext_ior"]
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(node.outputs[0], output.inputs["Surface"])
        return material

    def mesh(self, name, points, faces, material, smooth=False):
        np = self.np
        mesh = self.bpy.data.meshes.new(name)
        faces = np.ascontiguousarray(faces, np.int32)
        mesh.vertices.add(len(points))
        mesh.vertices.foreach_set("co", self.turned(np, points).astype(np.float32).ravel())
        mesh.loops.add(faces.size)
        mesh.loops.foreach_set("vertex_index", faces.ravel())
        mesh.polygons.add(len(faces))
        mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
        mesh.polygons.foreach_set("use_smooth", np.full(len(faces), smooth))
        mesh.materials.append(material)
        mesh.update(calc_edges=True)
        self.context.collection.objects.link(self.bpy.data.objects.new(name, mesh))

    def sphere(self, center, radius, rows):
        """A sphere of triangles, since Cycles has no sphere; slightly larger, so that its volume is exact."""
        np = self.np
        theta, phi = np.meshgrid(np.arange(rows + 1) / rows * math.pi, np.arange(2 * rows) / rows * math.pi, indexing="ij")
        points = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
        i, j = np.meshgrid(np.arange(rows), np.arange(2 * rows), indexing="ij")
        a, b = i * 2 * rows + j, i * 2 * rows + (j + 1) % (2 * rows)
        upper = np.stack([a, b, b + 2 * rows], -1)[1:].reshape(-1, 3)
        lower = np.stack([a, b + 2 * rows, a + 2 * rows], -1)[:-1].reshape(-1, 3)
        # One vertex per pole.
        faces = np.concatenate([upper, lower])
        faces[faces < 2 * rows] = 0
        faces[faces >= rows * 2 * rows] = rows * 2 * rows
        used, faces = np.unique(faces, return_inverse=True)
        grown = radius * (1 + (math.pi / rows) ** 2 / 6)
        return points[used] * grown + np.array(center), faces.reshape(-1, 3)

    def ply(self, path):
        """Reads a binary PLY of three floats per vertex and triangles with 32-bit indices, as Turner's example writes it."""
        np, counts = self.np, {}
        with open(path, "rb") as file:
            for line in iter(lambda: file.readline().split(), [b"end_header"]):
                if line[:1] == [b"element"]:
                    counts[line[1]] = int(line[2])
            points = np.frombuffer(file.read(12 * counts[b"vertex"]), "<f4").reshape(-1, 3)
            rows = np.frombuffer(file.read(13 * counts[b"face"]), [("n", "u1"), ("i", "<i4", 3)])
        return points, rows["i"]

    def emission(self, tree, output, color):
        tree.nodes.clear()
        emission, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new(output)
        emission.inputs["Color"].default_value = (*color, 1)
        emission.inputs["Strength"].default_value = 1
        tree.links.new(emission.outputs[0], end.inputs[0])

    def light(self, name, light):
        np = self.np
        if light["type"] == "analytic_env":
            self.world(light)
            return
        lamp = self.bpy.data.lights.new(name, "AREA" if light["type"] == "quad" else "POINT")
        lamp.use_nodes = True
        self.emission(lamp.node_tree, "ShaderNodeOutputLight", light["radiance"])
        lamp.color = (1, 1, 1)
        place = self.bpy.data.objects.new(name, lamp)
        place.visible_camera = True
        self.context.collection.objects.link(place)
        # The power in watts at which the light has the radiance of its node. Lights do not block light in
        # Cycles, so black bodies are added inside and behind them.
        if light["type"] == "sphere":
            radius = light["radius"]
            lamp.shadow_soft_size, lamp.use_soft_falloff = radius, False
            lamp.energy = 4 * math.pi**2 * radius**2
            place.location = self.turned(np, light["center"])
            self.mesh(name + "core", *self.sphere(light["center"], radius * 0.99, 24), self.black)
            return
        middle, u, w, n = lamp_axes(np, light)
        lamp.shape = "RECTANGLE"
        lamp.size, lamp.size_y = np.linalg.norm(w), np.linalg.norm(u)
        lamp.energy = math.pi * lamp.size * lamp.size_y
        # It emits along its own -z, so that the edges swap.
        axes = [self.turned(np, a / np.linalg.norm(a)) for a in (w, u)]
        columns = [*axes, np.cross(*axes), self.turned(np, middle)]
        place.matrix_world = self.matrix([[c[k] for c in columns] for k in range(3)] + [[0, 0, 0, 1]])
        back = np.array(light["vertices"], float) - n * 1e-4 * max(lamp.size, lamp.size_y)
        self.mesh(name + "back", back, [[0, 1, 2], [0, 2, 3]], self.black)

    def world(self, light):
        np, bpy, height = self.np, self.bpy, 1024
        def angles(u, v):
            phi, up = math.pi - 2 * math.pi * u, math.pi * (0.5 - v)
            # The description's axes are (x, z, -y) of Blender's (x, y, z).
            return np.cos(up) * np.cos(phi), np.sin(up), -np.cos(up) * np.sin(phi)
        pixels = np.ones((height, 2 * height, 4), np.float32)
        pixels[..., :3] = sky(np, sky_directions(np, height, angles), light)
        image = bpy.data.images.new("sky", 2 * height, height, float_buffer=True)
        image.colorspace_settings.name = "Linear Rec.709"
        image.pixels.foreach_set(pixels[::-1].ravel())
        image.update()
        world = bpy.data.worlds.new("sky")
        world.use_nodes = True
        nodes = world.node_tree.nodes
        nodes.clear()
        names = ("ShaderNodeTexEnvironment", "ShaderNodeBackground", "ShaderNodeOutputWorld")
        texture, background, output = (nodes.new(n) for n in names)
        texture.image = image
        world.node_tree.links.new(texture.outputs[0], background.inputs[0])
        world.node_tree.links.new(background.outputs[0], output.inputs[0])
        self.context.world = world

    def camera(self, c):
        np = self.np
        camera = self.bpy.data.cameras.new("camera")
        place = self.bpy.data.objects.new("camera", camera)
        self.context.collection.objects.link(place)
        self.context.camera = place
        camera.sensor_fit, camera.angle_y = "VERTICAL", math.radians(c["vfov_deg"])
        camera.clip_start, camera.clip_end = 1e-2, 1e5
        eye, target, up = (self.turned(np, c[k]) for k in ("origin", "target", "up"))
        forward = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(forward, up) / np.linalg.norm(np.cross(forward, up))
        columns = [right, np.cross(right, forward), -forward, eye]
        place.matrix_world = self.matrix([[v[k] for v in columns] for k in range(3)] + [[0, 0, 0, 1]])

    def settings(self, scene, threads):
        render, cycles = self.context.render, self.context.cycles
        render.engine = "CYCLES"
        self.width, self.height = render.resolution_x, render.resolution_y = scene["camera"]["res"]
        render.resolution_percentage = 100
        render.threads_mode, render.threads = "FIXED", threads
        # BVHs are kept from picture to picture.
        render.use_persistent_data = True
        render.use_compositing = render.use_sequencer = False
        settings = render.image_settings
        settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGB"
        settings.exr_codec = "NONE"
        cycles.device = "CPU"
        # The description counts the camera ray and the path's last ray to the light.
        bounces = scene["max_depth"] - 2
        cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
        # No biased noise reduction, and the same pixel filter for all renderers.
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
        cycles.caustics_reflective = cycles.caustics_refractive = True
        cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_auto_tile = False
        cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
        self.context.view_settings.view_transform = "Raw"

    def render(self, samples, seed):
        np, bpy, cycles = self.np, self.bpy, self.context.cycles
        cycles.samples, cycles.seed = samples, seed
        path = os.path.join(self.temporary.name, "picture.exr")
        self.context.render.filepath = path
        start = time.perf_counter()
        bpy.ops.render.render(write_still=True)
        seconds = time.perf_counter() - start
        image = bpy.data.images.load(path)
        pixels = np.empty(self.width * self.height * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        return pixels.reshape(self.height, self.width, 4)[::-1, :, :3], seconds, samples


def main():
    peer, path, threads = sys.argv[1], Path(sys.argv[2]).resolve(), int(sys.argv[3])
    if path.suffix.lower() == ".xml":
        renderer = MitsubaFile(peer, path, threads)
    else:
        scene = json.loads(path.read_text())
        renderer = Cycles(scene, path.parent, threads) if peer == "cycles" else Mitsuba(peer, scene, path.parent, threads)
    renderer.render(1, 0)
    first = time.perf_counter() - T0
    # This includes the time of a picture; Mitsuba's compiled variants have rendered two.
    usual = renderer.render(1, 1)[1] * (2 if getattr(renderer, "compiled", None) else 1)
    say(start_seconds=max(first - usual, 0.0), version=renderer.version)
    for line in sys.stdin:
        samples, seed, file = line.rstrip("\n").split(" ", 2)
        picture, seconds, samples = renderer.render(int(samples), int(seed))
        picture.astype("<f4").tofile(file)
        say(samples=samples, seconds=seconds, width=renderer.width, height=renderer.height)


if __name__ == "__main__":
    try:
        main()
    except ImportError as error:
        say(error=f"{error}", help="install the other renderers with --install-peers, or name a Python that has them with --python")
    except NoLlvm:
        say(error="there is no libLLVM of version 16 or newer under the usual names",
            help="install it (libllvm19), name it with DRJIT_LIBLLVM_PATH, or choose another renderer, such as mitsuba-scalar")
    except Exception as error:  # the caller reports any failure
        say(error=f"{type(error).__name__}: {error}", help="")
