"""Pictures with labels for learning: views of a scene with depth, normals, ids, masks, boxes and poses.

    import turner as tr

    scene = tr.load("model.glb")
    tr.dataset.views(scene, tr.dataset.orbit(100), out="views", aovs=["depth", "normal", "object_id"])

`views` writes pictures and `transforms.json` (instant-ngp, nerfstudio), COLMAP's text files, COCO's masks and boxes, and
BOP's poses. `Views` is the same as a sequence, for PyTorch's `DataLoader` without files. `items` varies a scene at random,
recorded, so that any item can be made again alone.
"""

from __future__ import annotations

from ._cameras import hemisphere, orbit
from ._coco import boxes, rle
from ._random import choice, color, item, items, normal, uniform
from ._views import Views, views
from ._write import write_png

__all__ = [
    "Views",
    "boxes",
    "choice",
    "color",
    "hemisphere",
    "item",
    "items",
    "normal",
    "orbit",
    "rle",
    "uniform",
    "views",
    "write_png",
]
