#!/usr/bin/env python3
"""Writes scenes/peers/night.json: a street at night with 2,000 lights (1,600 small spheres on strings, 360 windows, 40
street lamps) and puddles, for the comparison with other renderers. It is the street of
scenes/showcase/make_night_street.py, restricted to what all of them support.

    python3 benches/peers/night.py && python3 benches/peers/convert.py
"""
import json
import random
from pathlib import Path

OUT = Path(__file__).resolve().parents[2] / "scenes" / "peers" / "night.json"
COLORS = {"bulb": [55, 34, 15], "red": [55, 6.6, 3.3], "green": [8, 55, 14], "blue": [8, 19, 55]}
WINDOWS = {"warm": [0.5, 0.3, 0.135], "dim": [0.12, 0.06, 0.024], "cold": [0.18, 0.22, 0.3]}


def short(values):
    return [round(v, 4) for v in values]


def box(low, high, material):
    corners = [short([(low, high)[i >> k & 1][k] for k in range(3)]) for i in range(8)]
    sides = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]
    faces = [t for a, b, c, d in sides for t in ([a, b, c], [a, c, d])]
    return {"type": "mesh", "vertices": corners, "faces": faces, "material": material}


def floor(low, high, y, material):
    (x0, z0), (x1, z1) = low, high
    vertices = [short(p) for p in ([x0, y, z0], [x0, y, z1], [x1, y, z1], [x1, y, z0])]
    return {"type": "mesh", "vertices": vertices, "faces": [[0, 1, 2], [0, 2, 3]], "material": material}


def main():
    pick = random.Random(5)
    shapes, lights = [floor((-60, -90), (60, 30), 0, "asphalt")], []
    for k in range(40):
        z = 10 - 1.8 * k
        left, right = pick.uniform(5, 6.2), pick.uniform(5, 6.2)
        slant, sag = pick.uniform(-1, 1), pick.uniform(0.7, 1.2)
        pair = ["bulb", pick.choice(list(COLORS))]
        for i in range(40):
            t = (i + 0.5) / 40
            y = left + (right - left) * t - sag * 4 * t * (1 - t)
            center = short([-4.5 + 9 * t, y, z + slant * (2 * t - 1)])
            lights.append({"type": "sphere", "center": center, "radius": 0.035, "radiance": COLORS[pair[i % 2]]})
    places = []
    for side in (-1, 1):
        z = 14.0
        while z > -62:
            width, height = pick.uniform(6, 9), pick.choice([7.5, 9, 10.5])
            wall = pick.choice(["plaster", "brick"])
            x = sorted((side * 4.6, side * 12))
            shapes.append(box((x[0], 0, z - width), (x[1], height, z), wall))
            for storey in range(int(height / 1.8)):
                for i in range(int(width / 1.6)):
                    places.append((side, 1.6 + 1.8 * storey, z - 0.9 - 1.6 * i))
            z -= width
    for side, y, z in pick.sample(places, 360):
        x = side * 4.59
        corners = [[x, y - 0.6, z - 0.4], [x, y - 0.6, z + 0.4], [x, y + 0.6, z + 0.4], [x, y + 0.6, z - 0.4]]
        radiance = WINDOWS[pick.choice(["warm", "warm", "dim", "dim", "dim", "cold"])]
        lights.append({"type": "quad", "vertices": [short(p) for p in corners], "emit_normal": [-side, 0, 0], "radiance": radiance})
    for k in range(20):
        z = 9 - 3.6 * k
        for side in (-1, 1):
            x = side * 3.6
            shapes.append(box((x - 0.05, 0, z - 0.05), (x + 0.05, 4.2, z + 0.05), "iron"))
            corners = [[x - 0.16, 4.15, z + 0.1], [x - 0.16, 4.15, z + 0.42], [x + 0.16, 4.15, z + 0.42], [x + 0.16, 4.15, z + 0.1]]
            lights.append({"type": "quad", "vertices": [short(p) for p in corners], "emit_normal": [0, -1, 0], "radiance": [90, 65, 38]})
    for _ in range(60):
        x, z = pick.uniform(-4, 3), pick.uniform(-60, 10)
        shapes.append(floor((x, z), (x + pick.uniform(0.5, 1.5), z + pick.uniform(0.5, 3)), 0.004, "puddle"))
    scene = {
        "name": "night",
        "title": "A street at night under 2,000 lamps",
        "max_depth": 7,
        "camera": {"origin": [1.2, 1.7, 14], "target": [0, 3, -20], "up": [0, 1, 0], "vfov_deg": 58.0, "res": [480, 270]},
        "materials": {
            "asphalt": {"type": "diffuse", "reflectance": [0.06, 0.06, 0.06]},
            "plaster": {"type": "diffuse", "reflectance": [0.45, 0.4, 0.35]},
            "brick": {"type": "diffuse", "reflectance": [0.4, 0.2, 0.14]},
            "iron": {"type": "ggx_conductor", "alpha": 0.16, "reflectance": [0.3, 0.3, 0.3]},
            "puddle": {"type": "ggx_conductor", "alpha": 0.03, "reflectance": [0.3, 0.3, 0.3]},
        },
        "shapes": shapes,
        "lights": lights,
    }
    head = {k: v for k, v in scene.items() if k not in ("shapes", "lights")}
    lists = ",\n".join(f'"{k}": [\n' + ",\n".join(json.dumps(x) for x in scene[k]) + "\n]" for k in ("shapes", "lights"))
    OUT.write_text(json.dumps(head)[:-1] + ",\n" + lists + "\n}\n")
    print(len(lights), "lamps,", len(shapes), "shapes")


if __name__ == "__main__":
    main()
