#!/usr/bin/env python3
"""Makes the room of scenes/peers/interior.toml: one PLY file per material, and the description interior.json.

    python3 benches/peers/interior.py && python3 benches/peers/convert.py

A room of 6 x 3 x 5 m with a bright window, a lamp over a table, a polished floor, cushions, curtains, a rug and
bookshelves: about 60,000 flat-shaded, two-sided triangles. Needs only Python. Right-handed, y up, metres.
"""
import json
import math
import struct
from pathlib import Path

OUT = Path(__file__).resolve().parents[2] / "scenes" / "peers"


class Mesh:
    def __init__(self):
        self.points, self.faces = [], []

    def grid(self, rows, columns, at):
        """Two triangles per cell of a grid of points at(u, v), u and v from 0 to 1."""
        first = len(self.points)
        for i in range(rows + 1):
            for j in range(columns + 1):
                self.points.append(at(i / rows, j / columns))
        for i in range(rows):
            for j in range(columns):
                a = first + i * (columns + 1) + j
                b, c, d = a + 1, a + columns + 2, a + columns + 1
                # At a pole two corners of a cell coincide.
                self.faces += [f for f in ((a, b, c), (a, c, d)) if len({self.points[k] for k in f}) == 3]

    def box(self, low, high):
        x, y, z = zip(low, high)
        first = len(self.points)
        self.points += [(x[i & 1], y[i >> 1 & 1], z[i >> 2]) for i in range(8)]
        for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)):
            self.faces += [(first + a, first + b, first + c), (first + a, first + c, first + d)]

    def cushion(self, middle, size, power, n=28):
        """A superellipsoid: between a ball (power 1) and a box (power 0)."""
        def bent(v):
            v = round(v, 12)
            return math.copysign(abs(v) ** power, v)
        def at(u, v):
            theta, phi = math.pi * (u - 0.5), 2 * math.pi * v
            p = bent(math.cos(theta)) * bent(math.cos(phi)), bent(math.sin(theta)), bent(math.cos(theta)) * bent(math.sin(phi))
            return tuple(m + 0.5 * s * x for m, s, x in zip(middle, size, p))
        self.grid(n, 2 * n, at)

    def turned(self, middle, profile, rows=48, columns=48):
        """A surface of revolution around y: `profile` gives radius and height for t from 0 to 1."""
        def at(u, v):
            r, y = profile(u)
            return middle[0] + r * math.cos(2 * math.pi * v), middle[1] + y, middle[2] + r * math.sin(2 * math.pi * v)
        self.grid(rows, columns, at)

    def write(self, path):
        with open(path, "wb") as file:
            file.write((
                "ply\nformat binary_little_endian 1.0\n"
                f"element vertex {len(self.points)}\nproperty float x\nproperty float y\nproperty float z\n"
                f"element face {len(self.faces)}\nproperty list uchar int vertex_indices\nend_header\n").encode())
            for p in self.points:
                file.write(struct.pack("<3f", *p))
            for f in self.faces:
                file.write(struct.pack("<B3i", 3, *f))


def room():
    m = {name: Mesh() for name in ("wall", "floor", "wood", "cloth", "red", "blue", "brass")}
    # The room lies in x -3..3, y 0..3, z -2.5..2.5; the window is in the wall x = -3, z -1.2..1.0, y 0.9..2.4.
    m["floor"].grid(8, 8, lambda u, v: (-3 + 6 * u, 0, -2.5 + 5 * v))
    wall = m["wall"]
    wall.grid(8, 8, lambda u, v: (-3 + 6 * u, 3, -2.5 + 5 * v))
    wall.grid(8, 8, lambda u, v: (3, 3 * u, -2.5 + 5 * v))
    wall.grid(8, 8, lambda u, v: (-3 + 6 * v, 3 * u, -2.5))
    wall.grid(8, 8, lambda u, v: (-3 + 6 * v, 3 * u, 2.5))
    for low, high in (((0, -2.5), (3, -1.2)), ((0, 1.0), (3, 2.5)), ((0, -1.2), (0.9, 1.0)), ((2.4, -1.2), (3, 1.0))):
        wall.grid(4, 4, lambda u, v, a=low, b=high: (-3, a[0] + (b[0] - a[0]) * u, a[1] + (b[1] - a[1]) * v))
    for low, high in (((-3.3, 0.88, -1.2), (-2.9, 0.9, 1.0)), ((-3.3, 2.4, -1.2), (-3, 2.42, 1.0)),
                      ((-3.3, 0.9, -1.22), (-3, 2.4, -1.2)), ((-3.3, 0.9, 1.0), (-3, 2.4, 1.02)), ((-3.04, 0.9, -0.13), (-3, 2.4, -0.07))):
        wall.box(low, high)
    # A table with four legs, two stools, a shelf.
    wood = m["wood"]
    wood.box((0.2, 0.72, -0.6), (1.8, 0.76, 0.4))
    for x in (0.25, 1.69):
        for z in (-0.55, 0.29):
            wood.box((x, 0, z), (x + 0.06, 0.72, z + 0.06))
    for x in (0.5, 1.2):
        wood.box((x, 0.42, 0.75), (x + 0.4, 0.46, 1.15))
        for dx in (0.02, 0.34):
            for dz in (0.02, 0.34):
                wood.box((x + dx, 0, 0.75 + dz), (x + dx + 0.04, 0.42, 0.79 + dz))
    for y in (0.3, 0.75, 1.2, 1.65, 2.1):
        wood.box((2.62, y, -2.2), (3, y + 0.03, 0.6))
    for z in (-2.23, -0.82, 0.57):
        wood.box((2.62, 0.0, z), (3, 2.13, z + 0.03))
    # Books: widths, heights and leans from a small generator that gives the same numbers everywhere.
    state = 1
    def number():
        nonlocal state
        state = (state * 1103515245 + 12345) % 2**31
        return state / 2**31
    for y in (0.33, 0.78, 1.23, 1.68):
        for start in (-2.19, -0.78):
            z = start
            while z < start + 1.25:
                width, height = 0.02 + 0.035 * number(), 0.2 + 0.16 * number()
                m[("red", "blue", "cloth", "wood")[int(4 * number())]].box((2.68 + 0.05 * number(), y, z), (2.97, y + height, z + width))
                z += width + 0.002
                if number() < 0.06:
                    z += 0.15
    # A sofa with cushions along the back wall, a rug, curtains next to the window.
    blue = m["blue"]
    blue.box((-1.9, 0.08, -2.4), (0.3, 0.3, -1.5))
    for x in (-1.35, -0.25):
        blue.cushion((x, 0.38, -1.92), (1.08, 0.24, 0.85), 0.35)
        blue.cushion((x, 0.68, -2.28), (1.06, 0.5, 0.26), 0.35)
    for x in (-1.95, 0.35):
        blue.cushion((x, 0.4, -1.95), (0.22, 0.62, 0.95), 0.3)
    m["red"].cushion((-1.6, 0.62, -2.02), (0.42, 0.4, 0.18), 0.6)
    m["cloth"].cushion((-0.1, 0.62, -2.02), (0.42, 0.4, 0.18), 0.6)
    m["red"].grid(50, 66, lambda u, v: (-1.9 + 2.0 * u, 0.014 + 0.004 * math.sin(60 * u) * math.sin(84 * v), -1.2 + 2.6 * v))
    m["cloth"].grid(96, 28, lambda u, v: (-2.86 + 0.05 * math.sin(38 * u + 2 * v), 0.05 + 2.6 * v, 1.0 + 0.62 * u))
    m["cloth"].grid(96, 28, lambda u, v: (-2.86 + 0.05 * math.sin(37 * u - v), 0.05 + 2.6 * v, -1.82 + 0.62 * u))
    # A vase and a bowl on the table, the lampshade above.
    brass = m["brass"]
    brass.turned((0.75, 0.76, -0.2), lambda t: (0.02 + 0.09 * math.sin(math.pi * min(1, 0.12 + 0.88 * t)) ** 0.8 * (1 - 0.35 * t), 0.34 * t))
    brass.turned((1.35, 0.765, 0.05), lambda t: (0.02 + 0.17 * math.sqrt(t), 0.09 * t * t))
    m["cloth"].turned((1.0, 1.62, -0.1), lambda t: (0.27 - 0.22 * t, 0.2 * t), 16, 48)
    return m


def main():
    meshes = room()
    total = 0
    shapes = []
    for name, mesh in meshes.items():
        file = f"interior-{name}.ply"
        mesh.write(OUT / file)
        total += len(mesh.faces)
        shapes.append({"type": "ply", "file": file, "triangles": len(mesh.faces), "normals": "face (flat shading)", "material": name})
    matte = lambda r, g, b: {"type": "diffuse", "reflectance": [r, g, b]}
    scene = {
        "name": "interior",
        "title": f"A room of {total} triangles with a window, a lamp and a polished floor",
        "made_by": "python3 benches/peers/interior.py",
        "camera": {"origin": [0.4, 1.5, 2.42], "target": [-0.35, 0.95, -1.5], "up": [0, 1, 0], "vfov_deg": 62.0, "res": [256, 192]},
        "max_depth": 16,
        "materials": {
            "wall": matte(0.72, 0.69, 0.63), "wood": matte(0.36, 0.22, 0.12), "cloth": matte(0.66, 0.6, 0.5),
            "red": matte(0.5, 0.12, 0.08), "blue": matte(0.12, 0.22, 0.4),
            "floor": {"type": "ggx_conductor", "reflectance": [0.42, 0.36, 0.3], "alpha": 0.12},
            "brass": {"type": "ggx_conductor", "reflectance": [0.88, 0.66, 0.33], "alpha": 0.2},
        },
        "shapes": shapes,
        "lights": [
            {"type": "quad", "vertices": [[-3.25, 0.9, -1.2], [-3.25, 0.9, 1.0], [-3.25, 2.4, 1.0], [-3.25, 2.4, -1.2]],
             "emit_normal": [1, 0, 0], "radiance": [5.2, 6.2, 7.6]},
            {"type": "sphere", "center": [1.0, 1.66, -0.1], "radius": 0.06, "radiance": [38, 38, 38]},
        ],
    }
    text = json.dumps(scene, indent=1)
    (OUT / "interior.json").write_text(text + "\n")
    print(f"{total} triangles")


if __name__ == "__main__":
    main()
