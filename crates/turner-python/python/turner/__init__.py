"""Turner, a physically based ray tracer.

    import turner as tr

    scene = tr.load("room.glb")
    out = tr.render(scene, samples=64, aovs=["depth", "object_id"])
    out.image, out["depth"], out.names      # NumPy arrays, and the name of each number
    out.save("room.exr")

`render`, `Renderer`: pictures. `load`, `Scene` and the classes of its parts (`Sphere`, `PointLight`,
`PrincipledMaterial`, …): scenes. `explain`, `doctor`, `compare`, `denoise`, `convert`: tools. `turner.dataset`: pictures
with labels for learning. `turner.cluster`: many machines. docs/python.md is the guide.
"""

from __future__ import annotations

from . import _turner
from ._errors import SceneError, SceneWarning
from ._render import Labels, Picture, Renderer, labels, merge_films, render
from ._scene import Scene
from ._tools import Explanation, compare, convert, denoise, doctor, explain, load

__version__ = _turner.VERSION

_OWN = [
    "Explanation",
    "Labels",
    "Picture",
    "Renderer",
    "Scene",
    "SceneError",
    "SceneWarning",
    "compare",
    "convert",
    "denoise",
    "doctor",
    "explain",
    "labels",
    "load",
    "merge_films",
    "render",
]


def __getattr__(name):
    if name in ("dataset", "cluster"):
        import importlib

        return importlib.import_module(f"turner.{name}")
    if name == "__all__":
        from ._classes import classes

        return [*_OWN, *classes()]
    if name.startswith("_"):
        raise AttributeError(name)
    from ._classes import classes, near

    found = classes().get(name)
    if found is None:
        raise AttributeError(f"turner has no {name!r}{near(name, [*_OWN, *classes()])}")
    globals()[name] = found
    return found


def __dir__():
    from ._classes import classes

    return [*_OWN, *classes(), "cluster", "dataset"]
