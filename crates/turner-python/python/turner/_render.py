"""Rendering: pictures, and renderers that are watched, stopped, saved and merged."""

from __future__ import annotations

import os

from . import _turner
from ._scene import Scene, camera_edits, integrator_edits

#: Other names of AOVs.
AOV_NAMES = {"cryptomatte": "crypto_object", "ids": "object_id", "normals": "normal"}


def settings_edits(
    scene,
    samples=None,
    aovs=(),
    *,
    width=None,
    height=None,
    crop=None,
    seed=None,
    camera=None,
    integrator=None,
    denoise=None,
    adaptive=None,
    antialias=None,
    exposure=None,
    tonemap=None,
    settings=None,
):
    """The arguments of `render` as edits by key path."""
    edits = {}
    if integrator is not None:
        edits.update(integrator_edits(scene, integrator))
    if camera is not None:
        edits.update(camera_edits(scene, camera))
    aovs = [aovs] if isinstance(aovs, str) else list(aovs)
    values = {
        "samples": samples,
        "width": width,
        "height": height,
        "crop": None if crop is None else list(crop),
        "seed": seed,
        "denoise": {True: "on", False: "off"}.get(denoise, denoise) if denoise is not None else None,
        "adaptive_sampling": adaptive,
        "antialias": antialias,
        "exposure": exposure,
        "tonemap": tonemap,
        "aovs": [AOV_NAMES.get(aov, aov) for aov in aovs] or None,
    }
    edits.update({f"film.{key}": value for key, value in values.items() if value is not None})
    edits.update(settings or {})
    return edits


class Picture:
    """A rendered picture, as NumPy arrays. Rows run from the top, columns from the left.

    Attributes:
        image: (height, width, 4) float32, linear red, green, blue, premultiplied, and alpha: as in EXR files.
        display: (height, width, 4) uint8, with exposure, tone mapping and transfer curve: as in PNG files.
        aovs: dict of arrays (height, width) or (height, width, channels); `picture["depth"]` is short for it.
        names: dict, the name of each number in `object_id`.
        samples, rays, noise: samples per pixel, rays traced, and the relative error of the picture or None.
        camera: the camera as numbers: `K`, `opencv`, `opengl`, …
    """

    def __init__(self, parts, state, camera):
        self.image = parts["image"]
        self.display = parts["display"]
        self.aovs = parts["aovs"]
        self.has_alpha = parts["has_alpha"]
        self.exposure = parts["exposure"]
        self.attributes = parts["attributes"]
        self.samples, self.rays, self.noise = state["samples"], state["rays"], state["noise"]
        self.non_finite = state["non_finite"]
        self.complete = state["complete"]
        self.camera = camera
        self._channels = parts["channels"]
        self._names = parts["names"]

    @property
    def names(self):
        """The names of the numbers in `object_id`, from 1."""
        return self._names.get("object_id", {})

    @property
    def material_names(self):
        """The names of the numbers in `material_id`, from 1."""
        return self._names.get("material_id", {})

    @property
    def instance_names(self):
        """The names of the numbers in `instance_id`, from 1."""
        return self._names.get("instance_id", {})

    @property
    def width(self):
        """Columns."""
        return self.image.shape[1]

    @property
    def height(self):
        """Rows."""
        return self.image.shape[0]

    @property
    def rgb(self):
        """(height, width, 3) float32, linear, premultiplied: a view of `image`."""
        return self.image[..., :3]

    def __getitem__(self, aov):
        name = AOV_NAMES.get(aov, aov)
        if name not in self.aovs:
            have = ", ".join(self.aovs) or "none"
            raise KeyError(f"the picture has no AOV {aov!r}: render with aovs=[{aov!r}]; it has {have}")
        return self.aovs[name]

    def __contains__(self, aov):
        return AOV_NAMES.get(aov, aov) in self.aovs

    def mask(self, name):
        """The part of each pixel that an object of this name covers: (height, width) float32, from 0 to 1.

        From `crypto_object` with smooth edges, or from `object_id` with hard ones.
        """
        import numpy as np

        numbers = [number for number, own in self.names.items() if own == name]
        if not numbers:
            from ._classes import near

            raise KeyError(f"no object has the name {name!r}{near(name, list(self.names.values()))}")
        if "crypto_object" in self.aovs:
            matte = self.aovs["crypto_object"]
            ids = matte[..., 0::2].view(np.uint32) if matte.flags.c_contiguous else matte[..., 0::2].copy().view(np.uint32)
            return np.where(ids == matte_id(name), matte[..., 1::2], 0).sum(-1, dtype=np.float32)
        return np.isin(self["object_id"], numbers).astype(np.float32)

    def save(self, path, metadata=None):
        """Writes .png, .jpg, .webp, .exr or .hdr. EXR files hold the AOVs, with the channel names of the command line."""
        import numpy as np

        channels = []
        is_exr = os.fspath(path).lower().endswith(".exr")
        for name, array in self.aovs.items() if is_exr else ():
            planes = array[..., None] if array.ndim == 2 else array
            for i, channel in enumerate(self._channels[name]):
                channels.append((channel, np.ascontiguousarray(planes[..., i]).reshape(-1)))
        about = {"Software": f"Turner {_turner.VERSION}", **(metadata or {})}
        if is_exr:
            about = {"turner:software": about.pop("Software"), **about, **self.attributes}
        image, display = np.ascontiguousarray(self.image), np.ascontiguousarray(self.display)
        _turner.save_picture(os.fspath(path), image, display, self.has_alpha, channels, about)

    def png(self):
        """The bytes of a PNG file."""
        import tempfile

        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "picture.png")
            self.save(path)
            with open(path, "rb") as file:
                return file.read()

    def _repr_png_(self):
        return self.png()

    def __array__(self, dtype=None, copy=None):
        return self.image if dtype is None else self.image.astype(dtype)

    def __repr__(self):
        names = ", ".join(self.aovs) or "none"
        return f"<turner.Picture {self.width} x {self.height}, {self.samples:g} samples per pixel, aovs: {names}>"


def matte_id(name):
    """The number of a name in a Cryptomatte (MurmurHash3, 32 bits, as the bits of a normal float)."""
    data = name.encode()
    mask = 0xFFFFFFFF

    def rotated(value, by):
        return (value << by | value >> (32 - by)) & mask

    def mixed(value):
        return rotated(value * 0xCC9E2D51 & mask, 15) * 0x1B873593 & mask

    value = 0
    whole = len(data) // 4 * 4
    for i in range(0, whole, 4):
        value = (rotated(value ^ mixed(int.from_bytes(data[i : i + 4], "little")), 13) * 5 + 0xE6546B64) & mask
    if data[whole:]:
        value ^= mixed(int.from_bytes(data[whole:], "little"))
    value ^= len(data)
    value = (value ^ value >> 16) * 0x85EBCA6B & mask
    value = (value ^ value >> 13) * 0xC2B2AE35 & mask
    value ^= value >> 16
    exponent = value >> 23 & 255
    return value ^ 1 << 23 if exponent in (0, 255) else value


class Renderer:
    """Renders a scene pass by pass: to watch it, to stop it, to save and merge its samples.

    Arguments are those of `turner.render`. The scene is that of now: later edits do not change the renderer. While `run` works
    on one thread, others may read (`samples`, `noise`, `picture`, `film`, …): the run pauses for it between two samples, and
    its result has the same bytes. `run`, `step`, `load`, `merge` and `unlimited` wait for its end.
    """

    def __init__(self, scene, samples=None, aovs=(), *, threads=0, **settings):
        scene = Scene._of(scene) if isinstance(scene, _turner.Scene) else scene
        edits = settings_edits(scene, samples, aovs, **settings)
        self._inner = scene._inner.renderer(edits, threads)

    def run(self, samples=None, *, seconds=None, noise=None, progress=None, first=0):
        """Traces samples until every pixel has them, the time is over, the noise is low enough, or it is cancelled.

        samples: the samples per pixel to reach; None: all of the picture. first: the first sample index, for parts.
        seconds: time limit. noise: relative error that 95 % of the pixels do not exceed, e.g. 0.02.
        progress: True for a bar, or a function of the fraction that is done. Returns whether it ended of itself.
        """
        from ._progress import reporter

        with reporter(progress) as report:
            return self._inner.run(first, samples, seconds, noise, report)

    def step(self, samples=1):
        """Adds samples to every pixel. Returns whether the picture is complete."""
        done = int(self._inner.state()["samples"])
        self.run(done + samples)
        return self.complete

    async def run_async(self, samples=None, *, seconds=None, noise=None, progress=None):
        """`run` for asyncio: other tasks continue. Cancelling the task cancels the run."""
        import asyncio

        task = asyncio.get_running_loop().run_in_executor(
            None, lambda: self.run(samples, seconds=seconds, noise=noise, progress=progress)
        )
        try:
            return await asyncio.shield(task)
        except asyncio.CancelledError:
            self.cancel()
            await asyncio.wait([task])
            raise

    def unlimited(self):
        """Lifts the limit of samples, before the first one: `seconds` or `noise` of `run` ends the picture."""
        self._inner.open()
        return self

    def cancel(self):
        """Ends a run on another thread within milliseconds. Its samples stay."""
        self._inner.cancel()

    def picture(self):
        """The picture so far."""
        parts = self._inner.develop()
        return Picture(parts, parts["state"], self._inner.camera())

    def film(self):
        """The samples so far as bytes. Equal samples have equal bytes, whatever the threads and passes were."""
        return self._inner.film()

    def load(self, film):
        """Replaces the samples by those of `film`."""
        self._inner.load_film(bytes(film))

    def merge(self, film):
        """Adds the samples of `film`, of the same picture; no sample may be in both."""
        self._inner.merge_film(bytes(film))

    def warn(self):
        """Issues the warnings about the scene as `turner.SceneWarning`."""
        self._inner.warn()

    @property
    def samples(self):
        """Samples per pixel so far."""
        return self._inner.state()["samples"]

    @property
    def complete(self):
        """Whether all samples are traced."""
        return self._inner.state()["complete"]

    @property
    def noise(self):
        """The relative error that 95 % of the pixels do not exceed; None with too few samples."""
        return self._inner.noise()

    @property
    def camera(self):
        """The camera as numbers: `K`, `opencv` and `opengl` matrices, …"""
        return self._inner.camera()


def render(scene, samples=None, aovs=(), *, seconds=None, noise=None, progress=None, threads=0, warn=True, **settings):
    """Renders a scene and returns its `Picture`.

    scene: a `Scene`, or the path of a scene or model. It is not changed.
    samples: samples per pixel; by default those of the scene.
    aovs: further channels, e.g. ["depth", "normal", "object_id", "cryptomatte"].
    seconds: the time that tracing may take; noise: the relative error to reach. Without `samples` they alone end it.
    width, height: pixels. crop: (x, y, columns, rows). seed: of the random numbers.
    camera: a camera instead of the scene's. integrator: a name or a class. denoise: True, False, "fast" or "oidn".
    adaptive: whether noisy parts get more samples. antialias, exposure (stops), tonemap: as in scene files.
    settings: further values by key path, e.g. {"integrator.max_depth": 4}.
    threads: 0 uses all. progress: True for a bar, or a function of the fraction that is done. warn: whether warnings are
    issued.

    The same arguments give the same bytes on every run and any number of threads (`seconds` excepted). Ctrl-C ends it
    within a fraction of a second. The GIL is released while it works.
    """
    if not isinstance(scene, Scene):
        from ._tools import load

        scene = load(scene, warn=warn)
    renderer = Renderer(scene, samples, aovs, threads=threads, **settings)
    if samples is None and (seconds is not None or noise is not None):
        renderer.unlimited()
    if warn:
        renderer.warn()
    renderer.run(seconds=seconds, noise=noise, progress=progress)
    return renderer.picture()


class Labels:
    """Arrays about what the centres of pixels show: `turner.labels`.

    Attributes:
        aovs: dict of arrays (height, width) or (height, width, channels); `labels["depth"]` is short for it.
        names, material_names, instance_names: the names of numbers, from 1.
        camera: the camera as numbers.
    """

    def __init__(self, parts):
        self.aovs = parts["aovs"]
        self.camera = parts["camera"]
        self.names = parts["names"].get("object_id", {})
        self.material_names = parts["names"].get("material_id", {})
        self.instance_names = parts["names"].get("instance_id", {})

    def __getitem__(self, aov):
        return self.aovs[AOV_NAMES.get(aov, aov)]

    def __repr__(self):
        return f"<turner.Labels {self.camera['width']} x {self.camera['height']}: {', '.join(self.aovs)}>"


#: The AOVs that `labels` knows.
OF_SURFACES = (
    *("albedo", "normal", "geometric_normal", "camera_normal", "depth", "distance", "position", "uv", "motion"),
    *("object_id", "material_id", "instance_id"),
)


def labels(scene, aovs=("depth", "normal", "object_id"), *, threads=0, **settings):
    """AOVs of the surfaces at the centres of pixels, without light: fast, and without a mix of two surfaces in a pixel.

    aovs: any of "albedo", "normal", "geometric_normal", "camera_normal", "depth", "distance", "position", "uv", "motion",
    "object_id", "material_id", "instance_id". Motion blur and depth of field are left out. Other arguments are those of
    `render`. Returns `Labels`.
    """
    return Labels(scene._inner.labels(settings_edits(scene, None, aovs, **settings), threads))


def merge_films(films):
    """The films of parts of one picture (`Renderer.film`) as one, in any order.

    A `SceneError` names films that are damaged, belong to different pictures, hold the same samples, or leave a gap.
    """
    return _turner.merge_films([bytes(film) for film in films])
