#!/usr/bin/env python3
"""Writes scenes/guides/fur.hair: strands on a ball of radius 1, combed and curled.

    python3 scripts/make_fur.py scenes/guides/fur.hair
"""

import math
import random
import struct
import sys

STRANDS, POINTS, LENGTH = 1000, 5, 0.5


def unit(v):
    size = math.sqrt(sum(x * x for x in v)) or 1.0
    return [x / size for x in v]


def main():
    pick = random.Random(1)
    points, widths = [], []
    for i in range(STRANDS):
        # Fibonacci lattice, shaken.
        z = 1 - 2 * (i + pick.random()) / STRANDS
        turn = i * 2.399963 + 0.3 * pick.random()
        r = math.sqrt(max(0.0, 1 - z * z))
        n = [r * math.cos(turn), z, r * math.sin(turn)]
        length = LENGTH * (0.7 + 0.6 * pick.random())
        lean = [pick.gauss(0, 0.25) for _ in n]
        p = [0.97 * x for x in n]
        d = unit([a + b for a, b in zip(n, lean)])
        for k in range(POINTS):
            points.extend(p)
            widths.append(0.022 * (1 - 0.85 * k / (POINTS - 1)))
            # Towards the ground, more and more.
            d = unit([d[0], d[1] - 0.28, d[2]])
            p = [a + b * length / (POINTS - 1) for a, b in zip(p, d)]
    arrays = 2 | 4
    header = struct.pack("<4sIIIIff3f", b"HAIR", STRANDS, STRANDS * POINTS, arrays, POINTS - 1, 0.02, 0, 1, 1, 1)
    with open(sys.argv[1], "wb") as out:
        out.write(header.ljust(128, b"\0"))
        out.write(struct.pack(f"<{len(points)}f", *points))
        out.write(struct.pack(f"<{len(widths)}f", *widths))


main()
