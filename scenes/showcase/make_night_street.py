"""Makes night-street.toml: a wet street at night under 2,000 lamps. Needs Python 3 alone.

    python3 make_night_street.py
"""

import random

HEAD = """# A wet street at night with 2,000 lights: bulbs on strings, street lights, windows. Made by make_night_street.py.

[camera]
position = [1.2, 1.7, 14]
look_at = [0, 3.0, -20]
fov = 58

[film]
width = 720
height = 405
transfer = "srgb"
tonemap = "agx"
antialias = "monte-carlo"
samples = 128

[integrator]
type = "path"
max_depth = 6

[[light]]
type = "environment"
strength = 0.02
tint = [0.25, 0.4, 1]

[material.asphalt]
type = "principled"
base_color = 0.06
specular_roughness = 0.22

[material.plaster]
type = "matte"
color = [0.45, 0.4, 0.35]

[material.brick]
type = "matte"
color = [0.4, 0.2, 0.14]

[material.iron]
type = "principled"
base_color = 0.05
specular_roughness = 0.4

[material.bulb]
type = "emissive"
color = [1, 0.62, 0.28]
strength = 55

[material.mantle]
type = "principled"
base_weight = 0
specular_weight = 0
emission_color = [1, 0.72, 0.42]
emission_luminance = 90
double_sided = false

[material.warm]
type = "emissive"
color = [1, 0.6, 0.27]
strength = 0.5

[material.dim]
type = "emissive"
color = [1, 0.5, 0.2]
strength = 0.12

[material.cold]
type = "emissive"
color = [0.6, 0.75, 1]
strength = 0.3

[[group.lamp.object]]
type = "cylinder"
from = [0, 0, 0]
to = [0, 4.2, 0]
radius = 0.06
material = "iron"

[[group.lamp.object]]
type = "disk"
center = [0, 4.3, 0]
radius = 0.35
normal = [0, 1, 0]
material = "iron"

[[group.lamp.object]]
type = "disk"
center = [0, 4.25, 0]
radius = 0.18
normal = [0, -1, 0]
material = "mantle"

[[group.window.object]]
type = "rectangle"
edge_u = [0.8, 0, 0]
edge_v = [0, 1.2, 0]
"""

COLORS = {
    "bulb": None,
    "red": "[1, 0.12, 0.06]",
    "green": "[0.15, 1, 0.25]",
    "blue": "[0.15, 0.35, 1]",
}


def numbers(values):
    return "[" + ", ".join(f"{v:.3g}" for v in values) + "]"


def main():
    pick = random.Random(5)
    out = [HEAD]
    for name, color in COLORS.items():
        if color:
            out.append(f'\n[material.{name}]\ntype = "emissive"\ncolor = {color}\nstrength = 55\n')
    bulbs = {name: [] for name in COLORS}
    # 40 strings of 40 bulbs from house to house, each string of two colours.
    for k in range(40):
        z = 10 - 1.8 * k
        left, right = pick.uniform(5, 6.2), pick.uniform(5, 6.2)
        slant, sag = pick.uniform(-1, 1), pick.uniform(0.7, 1.2)
        pair = ["bulb", pick.choice(list(COLORS))]
        for i in range(40):
            t = (i + 0.5) / 40
            x = -4.5 + 9 * t
            y = left + (right - left) * t - sag * 4 * t * (1 - t)
            bulbs[pair[i % 2]].append((x, y, z + slant * (2 * t - 1)))
    objects = ['{ type = "plane", material = "asphalt" }']
    for name, positions in bulbs.items():
        lines = ",\n  ".join(numbers(p) for p in positions)
        objects.append(f'{{ type = "points", material = "{name}", radii = {numbers([0.035] * len(positions))}, positions = [\n  {lines}] }}')
    places = []
    for side in (-1, 1):
        z = 14.0
        while z > -62:
            width, height = pick.uniform(6, 9), pick.choice([7.5, 9, 10.5])
            wall = pick.choice(["plaster", "brick"])
            x = sorted((side * 4.6, side * 12))
            objects.append(
                f'{{ type = "box", min = {numbers((x[0], 0, z - width))}, max = {numbers((x[1], height, z))}, material = "{wall}" }}')
            for floor in range(int(height / 1.8)):
                for i in range(int(width / 1.6)):
                    places.append((side * 4.59, 1.6 + 1.8 * floor, z - 0.9 - 1.6 * i))
            z -= width
    # 360 windows are lit.
    for p in pick.sample(places, min(360, len(places))):
        light = pick.choice(["warm", "warm", "dim", "dim", "dim", "cold"])
        objects.append(
            f'{{ type = "instance", group = "window", material = "{light}", transform = [{{ rotate = [0, 90, 0] }}, {{ translate = {numbers(p)} }}] }}')
    for k in range(20):
        for side in (-1, 1):
            objects.append(
                f'{{ type = "instance", group = "lamp", transform = [{{ translate = {numbers((side * 3.6, 0, 9 - 3.6 * k))} }}] }}')
    out.insert(0, "object = [\n" + ",\n".join(objects) + "]\n\n")
    # TOML wants what is no table first, behind the title.
    title, rest = HEAD.split("\n\n", 1)
    body = title + "\n\n" + out[0] + rest + "".join(out[2:])
    with open("night-street.toml", "w", encoding="utf-8") as f:
        f.write(body)
    print(sum(map(len, bulbs.values())), "bulbs,", min(360, len(places)), "windows of", len(places), "and 40 lamps")


if __name__ == "__main__":
    main()
