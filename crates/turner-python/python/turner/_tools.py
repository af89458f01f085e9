"""Functions: load, explain, doctor, compare, denoise, convert."""

from __future__ import annotations

import json
import os

from . import _turner
from ._render import Picture, Renderer, settings_edits
from ._scene import Scene


def load(
    path,
    *,
    integrator=None,
    time=None,
    animation=None,
    variant=None,
    defines=None,
    overrides=None,
    max_texture_size=None,
    allow_outside=False,
    allow_paths=(),
    max_memory=None,
    warn=True,
):
    """Loads a scene (.toml, .pbrt, Mitsuba's .xml) or a model (.glb, .gltf, .usdz, .usd, .usda,
    .usdc, .obj, .ply, .stl).

    A model without camera, lights or floor gets those of the default studio, as on the command line.
    integrator: replaces the scene's. time: of the animation, seconds. animation, variant: of a model, by name or index.
    defines: the `$name`s of a Mitsuba scene. overrides: values by key path as on the command line,
    e.g. {"film.samples": "64"}. max_texture_size: longest side of textures, pixels.
    allow_outside, allow_paths: what the file may read outside its folder. max_memory: MiB.

    Errors: `SceneError` with file, line and column. Warnings: `SceneWarning`.
    """
    shown = {key: value if isinstance(value, str) else json.dumps(value) for key, value in (overrides or {}).items()}
    inner = _turner.Scene.load(
        os.fspath(path),
        integrator,
        time,
        animation,
        None if variant is None else str(variant),
        list((defines or {}).items()),
        list(shown.items()),
        max_texture_size,
        allow_outside,
        list(allow_paths),
        max_memory,
    )
    if warn:
        inner.warn()
    return Scene._of(inner)


class Explanation(dict):
    """Why a pixel has its colour: the keys of docs/reference/explain.md. `print` shows the tree; a notebook shows a page."""

    def __init__(self, scene, edits, pixel, sample):
        self._made = (scene, edits, pixel, sample)
        super().__init__(json.loads(self._form("json")))

    def _form(self, form):
        scene, edits, pixel, sample = self._made
        return scene._inner.explain(edits, pixel, sample, form)

    def text(self):
        """The tree as text."""
        return self._form("text")

    def html(self):
        """An interactive page: one file without other files."""
        return self._form("html")

    def svg(self):
        """The tree and its rays as a drawing."""
        return self._form("svg")

    def _repr_html_(self):
        import html

        style = "width:100%;height:640px;border:0"
        return f'<iframe srcdoc="{html.escape(self.html())}" style="{style}" title="explanation of a pixel"></iframe>'

    def __str__(self):
        return self.text()

    def __repr__(self):
        x, y = self._made[2]
        return f"<explanation of pixel ({x}, {y}): {len(self.get('explained', []))} samples>"


def explain(scene, x, y, *, sample=None, samples=None, aovs=(), **settings):
    """Why the pixel in column `x`, row `y` has its colour: every ray, what it hit, what it contributed.

    sample: a sample index; by default those that contribute most. Other arguments are those of `render`.
    Returns a dict (docs/reference/explain.md) that prints as a tree.
    """
    edits = settings_edits(scene, samples, aovs, **settings)
    return Explanation(scene, edits, (int(x), int(y)), sample)


def doctor(scene, *, seconds=10.0, threads=0, samples=None, **settings):
    """Why a picture is black, noisy, washed out or slow. Returns a dict: docs/reference/doctor.md.

    seconds: the longest time that the examination takes. Other arguments are those of `render`.
    """
    edits = settings_edits(scene, samples, **settings)
    return json.loads(scene._inner.doctor(edits, float(seconds), threads))


def _canvas(picture, encoding):
    import numpy as np

    if isinstance(picture, Picture):
        array = picture.image if encoding == "linear" else _associated(picture.display)
        return np.ascontiguousarray(array, np.float32)
    array = np.asarray(picture)
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or array.shape[2] not in (1, 3, 4):
        raise ValueError(f"a picture of shape {array.shape}; expected (height, width), (…, 3) or (…, 4)")
    if array.dtype == np.uint8:
        array = array / np.float32(255)
    array = np.asarray(array, np.float32)
    if array.shape[2] == 1:
        array = np.repeat(array, 3, 2)
    if array.shape[2] == 3:
        array = np.concatenate([array, np.ones_like(array[..., :1])], 2)
    return np.ascontiguousarray(array)


def _associated(display):
    import numpy as np

    straight = display / np.float32(255)
    straight[..., :3] *= straight[..., 3:]
    return straight


def compare(reference, picture, *, encoding=None):
    """Error metrics of two pictures: a dict with `max`, `mean`, `rmse`, `relmse`, `psnr`, `ssim` and `flip`.

    Each is a `Picture`, or an array (height, width[, 1, 3 or 4]): uint8 and floats from 0 to 1 are display values, with
    `encoding="linear"` floats are linear light. Two `Picture`s are compared in linear light, as EXR files are, unless
    `encoding="display"`.
    """
    if encoding not in (None, "linear", "display"):
        raise ValueError(f'there is no encoding {encoding!r}; valid: "linear", "display"')
    both = isinstance(reference, Picture) and isinstance(picture, Picture)
    encoding = encoding or ("linear" if both else "display")
    a, b = _canvas(reference, encoding), _canvas(picture, encoding)
    return _turner.compare(a, b, encoding == "linear")


def denoise(scene, samples=None, aovs=(), **settings):
    """Renders a scene and removes its noise: `render` with `denoise="on"`. The renderer's own albedo, normals and
    distances guide it, so the same samples always give the same bytes."""
    from ._render import render

    return render(scene, samples, aovs, **{"denoise": "on", **settings})


def convert(source, target, *, overwrite=False, **options):
    """Converts a scene or model to an editable .toml scene or to .glb. Returns the files. Options are those of `load`."""
    return load(source, **options).save(target, overwrite)


__all__ = ["Explanation", "Renderer", "compare", "convert", "denoise", "doctor", "explain", "load"]
