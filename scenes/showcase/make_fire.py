"""Makes fire.grid: a flame of 32 x 60 x 32 cells, whose values are densities and temperatures alike. Needs Python 3 and NumPy.

    python3 make_fire.py
"""

import itertools
import pathlib

import numpy

SIZE = (32, 60, 32)
z, y, x = numpy.mgrid[0:SIZE[2], 0:SIZE[1], 0:SIZE[0]] + 0.5
x, y, z = 2 * x / SIZE[0] - 1, y / SIZE[1], 2 * z / SIZE[2] - 1


def noise(frequency, seed, px, py, pz):
    """Value noise in -1..1; coordinates of any range."""
    table = numpy.random.default_rng(seed).uniform(-1, 1, (32, 32, 32))
    places = [p * frequency for p in (pz, py, px)]
    cells = [numpy.floor(p).astype(int) for p in places]
    fractions = [p - c for p, c in zip(places, cells)]
    fractions = [f * f * (3 - 2 * f) for f in fractions]
    value = 0
    for corner in itertools.product((0, 1), repeat=3):
        weight = 1
        for bit, f in zip(corner, fractions):
            weight = weight * (f if bit else 1 - f)
        a, b, c = [(cell + bit) % 32 for cell, bit in zip(cells, corner)]
        value = value + weight * table[a, b, c]
    return value


def turbulence(seed, px, py, pz, first=2.0):
    return sum(noise(first * 2**i, seed + i, px, py, pz) / 2**i for i in range(4))


# Turbulence displaces the flame more with height; its tongues are stretched along y.
sway = 0.15 + y
px = x + 0.36 * sway * turbulence(1, x, 1.6 * y, z, 1.6)
pz = z + 0.36 * sway * turbulence(11, x, 1.6 * y, z, 1.6)
radius = numpy.hypot(px, pz)
width = 0.75 * (0.6 + 0.4 * numpy.sin(numpy.pi * numpy.clip(y + 0.2, 0, 1))) * numpy.clip(1 - y, 0, 1) ** 0.8
tongues = turbulence(21, px, 0.5 * y, pz, 3.0)
core = numpy.clip(1 - radius / numpy.maximum(width, 1e-3), 0, 1)
value = numpy.clip(1.6 * core - (0.2 + 1.3 * y) * (0.45 - tongues), 0, numpy.minimum(1, 2.5 * core))
value *= numpy.clip((1 - y) / 0.1, 0, 1) * numpy.clip(y / 0.05, 0, 1)
header = f"turner-grid 1\nsize {SIZE[0]} {SIZE[1]} {SIZE[2]}\nchannels density\ndata\n"
target = pathlib.Path(__file__).with_name("fire.grid")
target.write_bytes(header.encode() + value.astype("<f4").tobytes())
