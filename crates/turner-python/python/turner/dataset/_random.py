"""Domain randomisation: variations of a scene, drawn from seeds and recorded, so that any item can be made again alone."""

from __future__ import annotations

import json
import os
import zlib

from .._cameras import edits_of
from .._scene import camera_edits
from ._write import write_bytes


class Draw:
    """A random value: a function of a NumPy generator."""

    def __init__(self, draw, text):
        self.draw, self.text = draw, text

    def __repr__(self):
        return self.text


def uniform(low, high):
    """Numbers, or vectors of numbers, evenly between `low` and `high`."""
    import numpy as np

    def draw(rng):
        found = rng.uniform(low, high)
        return found.tolist() if isinstance(found, np.ndarray) else float(found)

    return Draw(draw, f"uniform({low}, {high})")


def normal(mean, deviation):
    """Numbers with a normal distribution."""
    return Draw(lambda rng: float(rng.normal(mean, deviation)), f"normal({mean}, {deviation})")


def choice(values):
    """One of several values, each as likely."""
    values = list(values)
    if not values:
        raise ValueError("choice needs at least one value")
    return Draw(lambda rng: values[int(rng.integers(len(values)))], f"choice({values!r})")


def color(value=(0.2, 1.0), saturation=(0.0, 1.0)):
    """Linear colours of any hue; value and saturation between two numbers."""
    import colorsys

    def draw(rng):
        hue, s, v = rng.uniform(), rng.uniform(*saturation), rng.uniform(*value)
        return list(colorsys.hsv_to_rgb(hue, s, v))

    return Draw(draw, f"color({value}, {saturation})")


def item(variations, index, seed=0):
    """The values of one item: a dict by key path. Each depends on `seed`, `index` and its own path alone.

    variations: a dict from key paths of the scene, or "camera", to `uniform(…)`, `choice(…)`, `color(…)`, a function of a
    NumPy generator, or a fixed value.
    """
    import numpy as np

    found = {}
    for path, variation in variations.items():
        key = [seed & 0xFFFFFFFFFFFFFFFF, index << 32 | zlib.crc32(path.encode())]
        rng = np.random.Generator(np.random.Philox(key=np.array(key, np.uint64)))
        if isinstance(variation, Draw):
            found[path] = variation.draw(rng)
        elif callable(variation):
            found[path] = variation(rng)
        else:
            found[path] = variation
    return found


def _plain(value):
    if hasattr(value, "_edits"):
        return {"edits": {key: _plain(part) for key, part in value._edits().items()}}
    if hasattr(value, "_plain_"):
        return {key: _plain(part) for key, part in value._plain_().items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    return value


def items(scene, count, variations, out, *, seed=0, first=0, samples=None, aovs=(), format="png", progress=None, **settings):
    """Renders `count` variations of a scene into the folder `out`: items `first` to `first + count` - 1.

    Item 48,313 is the same whether it is made alone or with others: `items(scene, 1, variations, out, first=48313)`.
    The values are recorded in items-FIRST-LAST.jsonl. The seed of the samples is the item's number, unless `seed` is one of
    `variations`' key paths `film.seed`. Other arguments are those of `views`. Returns the values of the items.
    """
    from .._progress import reporter
    from .._render import render
    from ._views import write_view

    out = os.fspath(out)
    os.makedirs(out, exist_ok=True)
    aovs = [aovs] if isinstance(aovs, str) else list(aovs)
    recorded, lines = [], []
    with reporter(progress) as report:
        for index in range(first, first + count):
            values = item(variations, index, seed)
            edits = {path: value for path, value in values.items() if path != "camera"}
            if "camera" in values:
                edits.update(camera_edits(scene, values["camera"]))
            edits.setdefault("film.seed", index & 0xFFFFFFFF)
            picture = render(scene, samples, aovs, settings=edits, warn=False, **settings)
            file = write_view(picture, out, index, list(picture.aovs), True, format)
            record = {"item": index, "seed": seed, "file": file, "values": {k: _plain(v) for k, v in values.items()}}
            lines.append(json.dumps({**record, "camera": picture.camera}))
            recorded.append(values)
            if report:
                report((index - first + 1) / count)
    name = f"items-{first:06}-{first + count - 1:06}.jsonl"
    write_bytes(os.path.join(out, name), ("\n".join(lines) + "\n").encode())
    return recorded


__all__ = ["choice", "color", "edits_of", "item", "items", "normal", "uniform"]
