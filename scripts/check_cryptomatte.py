#!/usr/bin/env python3
"""Checks Turner's Cryptomattes with Blender's own Cryptomatte node.

Renders a small scene with Turner, opens the EXR file in Blender's compositor, picks each object and each material by
its name, and compares the matte with the fraction of the pixel that the object covers. That fraction is known from a
second render in which the object alone emits light. Needs the Python module of Blender:

    python3.11 -m pip install bpy          # 250 MB
    python3.11 scripts/check_cryptomatte.py target/release/turner
"""

import pathlib
import subprocess
import sys
import tempfile

import bpy
import numpy

SIZE = (96, 64)
SAMPLES = 64
OBJECTS = {"floor": "grey", "ball": "red", "Würfel 2": "red", "front": "blue"}
SCENE = """
[film]
width = {width}
height = {height}
samples = {samples}
filter = "gaussian"

[integrator]
type = "path"
max_depth = 0

[camera]
type = "thin-lens"
position = [0, 1.2, 5]
look_at = [0, 0.6, 0]
fov = 35
lens_radius = 0.12
focus_distance = 5

{materials}
[[object]]
name = "floor"
type = "plane"
material = "{floor}"

[[object]]
name = "ball"
type = "sphere"
center = [-0.6, 0.7, 0]
radius = 0.7
material = "{ball}"
motion = {{ translate = [0.3, 0, 0] }}

[[object]]
name = "Würfel 2"
type = "box"
min = [0.2, 0, -0.8]
max = [1.1, 1, 0.2]
material = "{box}"

[[object]]
name = "front"
type = "sphere"
center = [0.5, 0.35, 2]
radius = 0.35
material = "{front}"
"""


def scene(emits):
    """The scene in which the objects of `emits` alone emit light; all other surfaces are black."""
    colors = {"grey": 0.5, "red": [1, 0, 0], "blue": [0, 0, 1]}
    materials = "".join(
        f'[material.{name}]\ntype = "matte"\ncolor = {color}\n\n' for name, color in colors.items()
    )
    materials += '[material.white]\ntype = "emissive"\nstrength = 1\n\n'
    materials += '[material.black]\ntype = "matte"\ncolor = "black"\n\n'
    chosen = {name: own if emits is None else "white" if name in emits else "black" for name, own in OBJECTS.items()}
    floor, ball, box, front = chosen.values()
    width, height = SIZE
    return SCENE.format(
        width=width, height=height, samples=SAMPLES, materials=materials, floor=floor, ball=ball, box=box, front=front
    )


def turner(program, folder, name, text, *options):
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    output = folder / f"{name}.exr"
    subprocess.run([program, str(path), "-o", str(output), "--quiet", *options], check=True)
    return output


def pixels(path):
    """The red channel of an EXR file, the lowest row first."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    values = numpy.empty(SIZE[0] * SIZE[1] * image.channels, numpy.float32)
    image.pixels.foreach_get(values)
    return values.reshape(SIZE[1], SIZE[0], -1)[:, :, 0]


class Compositor:
    """Blender's compositor with one Cryptomatte node, whose matte is the picture."""

    def __init__(self, exr, folder):
        self.folder = folder
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(scene.camera)
        render = scene.render
        render.engine = "CYCLES"
        scene.cycles.samples = 1
        render.resolution_x, render.resolution_y = SIZE
        render.resolution_percentage = 100
        render.image_settings.file_format = "OPEN_EXR"
        render.image_settings.color_mode = "RGB"
        render.image_settings.color_depth = "32"
        scene.view_settings.view_transform = "Raw"
        # Blender 5 keeps the nodes in a group; earlier versions in the scene.
        if hasattr(scene, "compositing_node_group"):
            tree = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
            scene.compositing_node_group = tree
            output = tree.nodes.new("NodeGroupOutput")
        else:
            scene.use_nodes = True
            tree = scene.node_tree
            tree.nodes.clear()
            output = tree.nodes.new("CompositorNodeComposite")
        self.node = tree.nodes.new("CompositorNodeCryptomatteV2")
        self.node.source = "IMAGE"
        self.node.image = bpy.data.images.load(str(exr))
        tree.links.new(self.node.outputs["Matte"], output.inputs[0])

    def matte(self, layer, name, number):
        self.node.layer_name = layer
        self.node.matte_id = name
        path = self.folder / f"matte-{number}.exr"
        bpy.context.scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        return pixels(path)


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        exr = turner(program, folder, "picture", scene(None), "--aov", "crypto_object,crypto_material")
        cases = [("CryptoObject", name, [name]) for name in OBJECTS]
        for material in dict.fromkeys(OBJECTS.values()):
            cases.append(("CryptoMaterial", material, [n for n, own in OBJECTS.items() if own == material]))
        exact = [
            turner(program, folder, f"exact-{i}", scene(emits)) for i, (_, _, emits) in enumerate(cases)
        ]
        compositor = Compositor(exr, folder)
        worst = 0.0
        for number, (layer, name, _) in enumerate(cases):
            matte = compositor.matte(layer, name, number)
            expected = pixels(exact[number])
            error = float(numpy.abs(matte - expected).max())
            partial = int(((expected > 0.01) & (expected < 0.99)).sum())
            print(f"{layer} {name!r}: largest difference {error:.2g}, {partial} pixels covered in part")
            if expected.max() < 0.5 or partial == 0:
                sys.exit(f"the scene does not show {name!r}")
            worst = max(worst, error)
        print(f"Blender {bpy.app.version_string}: largest difference {worst:.2g}")
        sys.exit(0 if worst < 1e-3 else 1)


main()
