"""Makes the pictures of docs/python.md, docs/datasets.md and docs/cluster.md: `python examples/python/pictures.py docs/images`.

Needs Pillow.
"""

import sys
from pathlib import Path

import numpy as np
import turner as tr
from PIL import Image

PALETTE = np.array([[24, 24, 28], [86, 180, 233], [230, 159, 0], [0, 158, 115], [204, 121, 167], [213, 94, 0]], np.uint8)


def shown_depth(depth):
    """Near is bright, far is dark."""
    near = depth.min()
    value = (near / depth) ** 1.5
    return np.repeat(np.uint8(255 * value)[..., None], 3, 2)


def shown_normal(normal):
    """x, y, z from -1 to 1 as red, green, blue."""
    return np.uint8(127.5 * (normal + 1))


def sheet(rows, path, quality=88):
    """Pictures in rows, with a thin gap."""
    gap = 4
    height, width = rows[0][0].shape[:2]
    out = np.full((len(rows) * (height + gap) - gap, len(rows[0]) * (width + gap) - gap, 3), 255, np.uint8)
    for y, row in enumerate(rows):
        for x, picture in enumerate(row):
            out[y * (height + gap) :, x * (width + gap) :][:height, :width] = picture[..., :3]
    Image.fromarray(out).save(path, quality=quality)


def room():
    """The scene of docs/python.md."""
    return tr.Scene(
        objects=[
            tr.Sphere(name="ball", center=(0, 1, 0), material=tr.PrincipledMaterial(base_color="tomato")),
            tr.Sphere(
                name="mirror",
                center=(-1.8, 0.7, 0.6),
                radius=0.7,
                material=tr.PrincipledMaterial(base_metalness=1, base_color="gold", specular_roughness=0.1),
            ),
            tr.Plane(name="floor", material=tr.PrincipledMaterial(base_color="ivory")),
        ],
        lights=[tr.EnvironmentLight()],
        camera=tr.Camera.look_at((0, 2.2, 6), (-0.4, 0.8, 0), fov=35),
        film=tr.Film(width=320, height=240),
        integrator="path",
    )


def model():
    """The scene of docs/datasets.md."""
    return tr.Scene(
        objects=[
            tr.Torus(
                name="ring",
                transform={"translate": [0, 1.2, 0], "rotate": [70, 0, 0]},
                material=tr.PrincipledMaterial(base_color="steelblue"),
            ),
            tr.Sphere(name="ball", radius=0.5, center=(0, 1.2, 0), material=tr.PrincipledMaterial(base_color="orange")),
            tr.Box(name="base", min=(-1.5, 0, -1.5), max=(1.5, 0.3, 1.5), material=tr.PrincipledMaterial(base_color="ivory")),
        ],
        lights=[tr.EnvironmentLight()],
        integrator="path",
    )


def main(folder):
    """Writes the pictures."""
    scene = room()
    out = tr.render(scene, 256, ["depth", "normal", "object_id"])
    sheet(
        [[out.display, shown_depth(out["depth"]), shown_normal(out["normal"]), PALETTE[out["object_id"]]]],
        folder / "python-room.jpg",
    )

    rows = [[], [], []]
    for camera in tr.dataset.orbit(4, elevation=25):
        out = tr.render(model(), 128, ["depth", "object_id"], camera=camera, width=240, height=180)
        for row, picture in zip(rows, (out.display, shown_depth(out["depth"]), PALETTE[out["object_id"]])):
            row.append(picture)
    sheet(rows, folder / "python-dataset.jpg")

    parts = []
    whole = tr.Renderer(scene, 16, width=240, height=180)
    for first in (0, 4, 8, 12):
        part = tr.Renderer(scene, 16, width=240, height=180)
        part.run(first + 4, first=first)
        parts.append(part)
    whole.load(tr.merge_films(part.film() for part in parts))
    sheet([[part.picture().display for part in parts[:3]] + [whole.picture().display]], folder / "python-cluster.jpg")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
