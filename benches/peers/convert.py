#!/usr/bin/env python3
"""Writes scenes/peers/s1.toml to s4.toml, interior.toml and night.toml from the neutral descriptions in the same folder
(s1.json and so on), with which other renderers are measured (render.py).

    python3 benches/peers/convert.py

Conventions of the descriptions: right-handed, y up; `max_depth` counts the camera ray (1 is directly visible light), so
that Turner's `max_depth` is one less; quads emit on one side and absorb on both; `alpha` is the GGX α, the square of
Turner's roughness; reflectances of mirrors and metals are constant. The small references are reduced from converged
pictures of 512 x 512 by `cargo run -p turner-io --features tools --example reduce_reference`.
"""
import json
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "scenes" / "peers"


def num(v):
    return repr(round(float(v), 12)).rstrip("0").rstrip(".") if "e" not in repr(float(v)) else repr(float(v))


def vec(v):
    return "[" + ", ".join(num(x) for x in v) + "]"


def rows(values, show):
    return "[" + ", ".join(show(v) for v in values) + "]"


def material(name, m):
    head = f"[material.{name}]\n"
    if m["type"] == "diffuse":
        return head + f'type = "matte"\ncolor = {vec(m["reflectance"])}\n'
    if m["type"] == "dielectric":
        assert m["ext_ior"] == 1.0
        return head + f'type = "dielectric"\nior = {num(m["int_ior"])}\n'
    # An index of refraction of 0 makes a perfect mirror with the same colour at all angles, without energy
    # compensation.
    rough = m.get("alpha", 0.0) ** 0.5
    return head + (
        'type = "principled"\nbase_weight = 0\nspecular_ior = 0\n'
        f'specular_color = {vec(m["reflectance"])}\nspecular_roughness = {num(rough)}\n'
    )


def emission(radiance):
    if len(set(radiance)) == 1:
        return f"emission_luminance = {num(radiance[0])}"
    return f"emission_luminance = 1, emission_color = {vec(radiance)}"


def quad(light):
    """A quad light. The order of its edges makes the normal point to the side that emits."""
    v = light["vertices"]
    u = [b - a for a, b in zip(v[0], v[1])]
    w = [b - a for a, b in zip(v[0], v[3])]
    cross = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]]
    if sum(a * b for a, b in zip(cross, light["emit_normal"])) < 0:
        u, w = w, u
    center = [sum(p[i] for p in v) / 4 for i in range(3)]
    size = max(abs(x) for p in v for x in p)
    # A black sheet behind the quad, so close that no light passes between them.
    back = [c - 1e-5 * size * n for c, n in zip(center, light["emit_normal"])]
    edges = f"edge_u = {vec(u)}\nedge_v = {vec(w)}\n"
    return (
        '[[object]]\ntype = "rectangle"\n'
        f"center = {vec(center)}\n{edges}"
        'material = { type = "principled", base_weight = 0, specular_weight = 0, double_sided = false, '
        f"emission_luminance = 1, emission_color = {vec(light['radiance'])} }}\n\n"
        f'[[object]]\ntype = "rectangle"\ncenter = {vec(back)}\n{edges}material = "black"\n'
    )


def convert(s):
    name = s["name"].lower()
    cam = s["camera"]
    parts = [
        f"# {s['title']}.\n# Written by benches/peers/convert.py; what it is compared with stands in README.md.\n",
        f'[camera]\nposition = {vec(cam["origin"])}\nlook_at = {vec(cam["target"])}\nup = {vec(cam["up"])}\n'
        f'fov = {num(cam["vfov_deg"])}\n',
        f'[integrator]\ntype = "path"\nmax_depth = {s["max_depth"] - 1}\n',
        f'[film]\nwidth = {cam["res"][0]}\nheight = {cam["res"][1]}\nantialias = "monte-carlo"\nsamples = 64\ntransfer = "srgb"\n',
        '[material.black]\ntype = "principled"\nbase_weight = 0\nspecular_weight = 0\n',
    ]
    parts += [material(k, m) for k, m in s["materials"].items()]
    for shape in s["shapes"]:
        if shape["type"] == "mesh":
            parts.append(
                '[[object]]\ntype = "mesh"\n'
                f'positions = {rows(shape["vertices"], vec)}\ntriangles = {rows(shape["faces"], str)}\n'
                f'material = "{shape["material"]}"\n'
            )
        elif shape["type"] == "sphere":
            parts.append(
                f'[[object]]\ntype = "sphere"\ncenter = {vec(shape["center"])}\nradius = {num(shape["radius"])}\n'
                f'material = "{shape["material"]}"\n'
            )
        else:
            if "made_by" in s:
                made = f"# `{s['made_by']}` made its files.\n"
            else:
                made = "# `cargo run --release -p turner-io --features tools --example peer_files` makes the two files it needs.\n"
            parts[0] += "" if parts[0].endswith(made) else made
            parts.append(
                f'[[object]]\ntype = "mesh"\nfile = "{shape["file"]}"\nsmooth = false\nmaterial = "{shape["material"]}"\n'
            )
    for light in s["lights"]:
        if light["type"] == "quad":
            parts.append(quad(light))
        elif light["type"] == "sphere":
            parts.append(
                f'[[object]]\ntype = "sphere"\ncenter = {vec(light["center"])}\nradius = {num(light["radius"])}\n'
                'material = { type = "principled", base_weight = 0, specular_weight = 0, '
                f"{emission(light['radiance'])} }}\n"
            )
        else:
            parts.append('[[light]]\ntype = "environment"\nfile = "s4-sky.exr"\n')
    (OUT / f"{name}.toml").write_text("\n".join(parts))


def main():
    for name in ("s1", "s2", "s3", "s4", "interior", "night"):
        convert(json.loads((OUT / f"{name}.json").read_text()))


if __name__ == "__main__":
    main()
