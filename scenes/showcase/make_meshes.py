"""Makes the meshes of the showcase scenes: bodies of revolution, from profiles, and the waves of a pool. Needs Python 3 alone.

    python3 make_meshes.py
"""

import math
import struct


def smooth(points, steps=6):
    """A Catmull-Rom curve through points (radius, height); a point given twice in a row is a corner."""
    out = []
    runs, run = [], [points[0]]
    for a, b in zip(points, points[1:]):
        if a == b:
            runs.append(run)
            run = [b]
        else:
            run.append(b)
    runs.append(run)
    for run in runs:
        for i in range(len(run) - 1):
            p0, p1, p2, p3 = run[max(i - 1, 0)], run[i], run[i + 1], run[min(i + 2, len(run) - 1)]
            for k in range(steps):
                t = k / steps
                out.append(tuple(
                    0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t + (3 * b - a - 3 * c + d) * t ** 3)
                    for a, b, c, d in zip(p0, p1, p2, p3)))
        out.append(run[-1])
    return [(max(r, 0.0), y) for r, y in out]


def lathe(profile, segments=96):
    """Turns a profile about the y axis. Normals point to the left of the profile's way."""
    positions, triangles, rings = [], [], []
    for r, y in profile:
        if r < 1e-9:
            rings.append([len(positions)] * segments)
            positions.append((0.0, y, 0.0))
        else:
            rings.append(list(range(len(positions), len(positions) + segments)))
            for s in range(segments):
                a = 2 * math.pi * s / segments
                positions.append((r * math.cos(a), y, r * math.sin(a)))
    for lower, upper in zip(rings, rings[1:]):
        for s in range(segments):
            a, b = lower[s], lower[(s + 1) % segments]
            c, d = upper[s], upper[(s + 1) % segments]
            if a != b and len({a, c, b}) == 3:
                triangles.append((a, c, b))
            if c != d and len({b, c, d}) == 3:
                triangles.append((b, c, d))
    return positions, triangles


def waves(width, depth, columns, rows):
    """Small waves on deep water over a rectangle around the origin: sines by the golden angle, the longer the higher; slopes of some 8 %."""
    trains = []
    for i in range(24):
        length = 1.5 * 0.9 ** i
        angle = 0.5 + 2.39996 * i
        trains.append((math.cos(angle) * math.tau / length, math.sin(angle) * math.tau / length,
                       0.0036 * length, 1.7 * i * i))
    positions = [
        (x, sum(a * math.sin(kx * x + kz * z + p) for kx, kz, a, p in trains), z)
        for x, z in ((width * (c / columns - 0.5), depth * (r / rows - 0.5))
                     for r in range(rows + 1) for c in range(columns + 1))]
    triangles = []
    for r in range(rows):
        for c in range(columns):
            i = r * (columns + 1) + c
            triangles += [(i, i + columns + 1, i + 1), (i + 1, i + columns + 1, i + columns + 2)]
    return positions, triangles


def write(name, mesh):
    positions, triangles = mesh
    with open(f"meshes/{name}.ply", "wb") as f:
        f.write((f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\n"
                 "property float x\nproperty float y\nproperty float z\n"
                 f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n").encode())
        for p in positions:
            f.write(struct.pack("<3f", *p))
        for t in triangles:
            f.write(struct.pack("<B3i", 3, *t))


# Profiles run up the outside, so that normals point outwards. Lengths in decimetres.
WINE_GLASS = smooth([
    (0.0, 0.0), (0.30, 0.0), (0.345, 0.004), (0.35, 0.012), (0.33, 0.022), (0.2, 0.045), (0.07, 0.09), (0.042, 0.16),
    (0.036, 0.4), (0.038, 0.7), (0.06, 0.82), (0.16, 0.9), (0.31, 1.03), (0.405, 1.22), (0.43, 1.45), (0.40, 1.7),
    (0.345, 1.93), (0.335, 1.945), (0.325, 1.93),
    (0.382, 1.7), (0.412, 1.45), (0.387, 1.22), (0.293, 1.05), (0.14, 0.93), (0.0, 0.885)])
# The wine reaches into the glass: where solids overlap, the denser one is there.
WINE = smooth([(0.0, 0.875), (0.14, 0.92), (0.3, 1.043), (0.393, 1.215), (0.412, 1.3), (0.417, 1.36), (0.417, 1.36),
               (0.405, 1.353), (0.38, 1.35), (0.0, 1.35)])
BOTTLE = smooth([
    (0.0, 0.03), (0.22, 0.01), (0.33, 0.0), (0.37, 0.02), (0.38, 0.07), (0.38, 0.6), (0.38, 1.25), (0.375, 1.55),
    (0.32, 1.78), (0.2, 2.0), (0.15, 2.15), (0.143, 2.4), (0.143, 2.7), (0.16, 2.71), (0.162, 2.78), (0.143, 2.8),
    (0.12, 2.8), (0.105, 2.78), (0.105, 2.4), (0.112, 2.15), (0.165, 2.0), (0.285, 1.76), (0.335, 1.53), (0.34, 1.25),
    (0.34, 0.6), (0.338, 0.1), (0.3, 0.06), (0.2, 0.075), (0.0, 0.1)])
VASE = smooth([
    (0.0, 0.0), (0.3, 0.0), (0.34, 0.02), (0.42, 0.2), (0.56, 0.5), (0.58, 0.75), (0.46, 1.05), (0.28, 1.3), (0.24, 1.42),
    (0.3, 1.55), (0.315, 1.57), (0.3, 1.575), (0.265, 1.55), (0.21, 1.42), (0.25, 1.3), (0.42, 1.05), (0.53, 0.75),
    (0.5, 0.5), (0.38, 0.22), (0.0, 0.06)])
BOWL = smooth([
    (0.0, 0.0), (0.34, 0.0), (0.36, 0.02), (0.36, 0.06), (0.5, 0.1), (0.8, 0.26), (1.02, 0.5), (1.08, 0.64), (1.07, 0.66),
    (1.05, 0.645), (0.98, 0.52), (0.77, 0.31), (0.48, 0.16), (0.0, 0.12)])
LIME = smooth([(0.0, 0.0), (0.05, 0.005), (0.17, 0.05), (0.26, 0.16), (0.29, 0.3), (0.26, 0.44), (0.17, 0.55), (0.08, 0.6),
               (0.05, 0.635), (0.0, 0.645)])
# A flask of thick glass, what is in it, and its stopper.
FLASK = smooth([
    (0.0, 0.0), (0.42, 0.0), (0.5, 0.02), (0.53, 0.08), (0.53, 0.3), (0.53, 0.72), (0.5, 0.84), (0.4, 0.9), (0.24, 0.92),
    (0.2, 0.94), (0.19, 0.98), (0.19, 1.08), (0.18, 1.1), (0.13, 1.1), (0.12, 1.08), (0.12, 0.95), (0.14, 0.87),
    (0.3, 0.83), (0.4, 0.78), (0.43, 0.68), (0.43, 0.3), (0.42, 0.22), (0.34, 0.17), (0.0, 0.16)])
PERFUME = smooth([(0.0, 0.15), (0.345, 0.16), (0.425, 0.21), (0.436, 0.3), (0.436, 0.55), (0.436, 0.6), (0.436, 0.6),
                  (0.42, 0.594), (0.38, 0.592), (0.0, 0.592)])
CAP = smooth([(0.0, 1.0), (0.26, 1.0), (0.28, 1.01), (0.29, 1.03), (0.29, 1.3), (0.29, 1.52), (0.285, 1.55), (0.265, 1.57),
              (0.2, 1.575), (0.0, 1.575)])
# A candle with the hollow that its flame has melted, and the flame.
CANDLE = smooth([(0.0, 0.0), (0.32, 0.0), (0.345, 0.012), (0.352, 0.05), (0.35, 0.5), (0.347, 0.98), (0.345, 1.1), (0.338, 1.155),
                 (0.318, 1.178), (0.29, 1.165), (0.262, 1.125), (0.2, 1.1), (0.1, 1.092), (0.0, 1.09)])
FLAME = smooth([(0.0, 1.175), (0.022, 1.18), (0.05, 1.22), (0.063, 1.29), (0.056, 1.38), (0.037, 1.48), (0.016, 1.57), (0.0, 1.63)], 2)

for name, profile in [
    ("wine_glass", WINE_GLASS), ("wine", WINE), ("bottle", BOTTLE), ("vase", VASE), ("bowl", BOWL), ("lime", LIME),
    ("flask", FLASK), ("perfume", PERFUME), ("cap", CAP),
    ("candle", CANDLE),
]:
    write(name, lathe(profile, 72))
write("waves", waves(8.1, 5.1, 120, 76))
# Each of its triangles is a light.
write("flame", lathe(FLAME, 16))
